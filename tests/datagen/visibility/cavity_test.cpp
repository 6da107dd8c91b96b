#include "datagen/visibility/cavity.h"

#include <gtest/gtest.h>

#include "datagen/visibility/support_visibility.h"
#include "runtime_eval/numbers/random.h"
#include "tests/scene/windowed_room.h"

namespace nlg {
namespace {

Scene sheets() {
  Scene scene = sceneOfMaterial(true);
  scene.cavity_m = 0.5;
  return scene;
}

constexpr int kPlaces = 400;
constexpr int kFew =
    kPlaces / 100;  // walks are random: one place in a hundred may be judged wrongly where openings are hard to find

// How many random places of a box lie in a cavity.
int inCavity(const Scene& scene, const glm::dvec3& low, const glm::dvec3& high) {
  const RayScene rays(scene);
  Random random(7);
  int count = 0;
  for (int i = 0; i < kPlaces; ++i) {
    glm::dvec3 at;
    for (int axis = 0; axis < 3; ++axis) at[axis] = random.uniform(low[axis], high[axis]);
    count += isInCavity(rays, at);
  }
  return count;
}

TEST(Cavity, IsBetweenTheSheetsOfAWall) {
  const Scene room = windowedRoom(true);
  const glm::dvec3 low(kRoomLow), high(kRoomHigh), wall(kWallM);
  EXPECT_EQ(inCavity(room, {low.x, low.y, low.z - kWallM}, {high.x, high.y, low.z}), kPlaces);
  EXPECT_EQ(inCavity(room, {kWindowHigh.x, low.y, high.z}, {high.x, high.y, high.z + kWallM}), kPlaces) << "beside the window";
  EXPECT_EQ(inCavity(room, low, high), 0) << "the room";
  EXPECT_EQ(inCavity(room, glm::dvec3(kWindowLow), glm::dvec3(kWindowHigh)), 0) << "the window";
  EXPECT_EQ(inCavity(room, high + wall, high + 3.0), 0) << "outside";
}

TEST(Cavity, IsNotInAClosedDarkRoom) {
  Scene room = sheets();
  addBox(room, {0, 0, 0}, {3, 2.5f, 3});
  EXPECT_EQ(inCavity(room, {0, 0, 0}, {3, 2.5, 3}), 0);
}

TEST(Cavity, IsNotBehindAWardrobeNorUnderABed) {
  Scene room = sheets();
  addRoom(room, {-2, 0, -2}, {2, 2.5f, 2});
  addBox(room, {-0.9f, 0.0f, 1.35f}, {0.9f, 2.2f, 1.95f});  // 5 cm before the wall, down to the floor
  addBox(room, {-1.95f, 0.25f, -1.9f}, {-0.5f, 0.6f, 0.1f});
  EXPECT_LE(inCavity(room, {-0.9, 0.0, 1.95}, {0.9, 2.2, 2.0}), kFew) << "behind the wardrobe";
  EXPECT_EQ(inCavity(room, {-1.95, 0.0, -1.9}, {-0.5, 0.25, 0.1}), 0) << "under the bed";
  EXPECT_EQ(inCavity(room, {-1.95, 0.25, -1.9}, {-0.5, 0.6, 0.1}), kPlaces) << "in its box";
}

TEST(Cavity, IsADuctUntilOneEndIsOpen) {
  Scene closed = sheets();
  addBox(closed, {0, 0, 0}, {4, 0.3f, 0.3f});
  Scene open = closed;
  const glm::dvec3 low(0), high(4, 0.3, 0.3);
  EXPECT_EQ(inCavity(closed, low, high), kPlaces);
  // without the end at x = 4, of which all corners have that x
  for (size_t t = open.triangles.size(); t-- > 0;) {
    const glm::uvec3& corners = open.triangles[t];
    if (open.positions[corners.x].x + open.positions[corners.y].x + open.positions[corners.z].x == 12.0f) {
      open.triangles.erase(open.triangles.begin() + static_cast<ptrdiff_t>(t));
      open.triangle_material.pop_back();
    }
  }
  ASSERT_EQ(open.triangles.size(), closed.triangles.size() - 2);
  EXPECT_LE(inCavity(open, low, high), kFew);
}

// A millimetre all round below a wall's sheet: rays pass it, nobody does.
TEST(Cavity, DoesNotMindACrack) {
  Scene wall = sheets();
  addRoom(wall, {-2, 0, -2}, {2, 3, 2});
  addQuad(wall, {-2, 0.001f, -1.8f}, {4, 0, 0}, {0, 2.999f, 0});
  EXPECT_GE(inCavity(wall, {-2, 0, -2}, {2, 3, -1.8}), kPlaces - kFew);
}

TEST(Cavity, IsNowhereWhereTheSceneSaysSo) {
  Scene duct = sheets();
  addBox(duct, {0, 0, 0}, {4, 0.3f, 0.3f});
  duct.cavity_m = 0.0;
  EXPECT_EQ(inCavity(duct, {0, 0, 0}, {4, 0.3, 0.3}), 0);
  duct.cavity_m = 0.2;
  EXPECT_LE(inCavity(duct, {0, 0, 0}, {4, 0.3, 0.3}), kFew) << "a ball of 20 cm is free in it";
}

// The wall's twin in solid says what a probe beside it should see, and what of its support should count.
TEST(Cavity, IsSolidToProbes) {
  const LinkTable links = makeLinkTable({});
  const Scene hollow = windowedRoom(true), solid = windowedRoom(false);
  const RayScene hollow_rays(hollow), solid_rays(solid);
  SupportVisibility of_hollow(hollow_rays, links), of_solid(solid_rays, links);
  for (const glm::dvec3& probe : {glm::dvec3(1.0, 1.3, 1.2), glm::dvec3(-1.7, 0.3, -1.3), glm::dvec3(0.9, 1.3, 2.0)}) {
    for (SupportVisibility* visibility : {&of_hollow, &of_solid}) {
      visibility->beginProbe(probe, 1.0f);
      EXPECT_FALSE(visibility->probeVote().solid());
      visibility->traceProbeRays();
      visibility->testLinks();
      visibility->findValidity();
    }
    for (uint32_t point = 0; point < links.points.size(); ++point)
      ASSERT_EQ(of_hollow.valid(point), of_solid.valid(point)) << "point " << point << " around " << probe.x;
  }
  const SolidVote vote = of_hollow.voteAt({1.2, 1.3, 1.6});
  EXPECT_TRUE(vote.solid());
  EXPECT_TRUE(vote.in_cavity);
  EXPECT_FALSE(of_solid.voteAt({1.2, 1.3, 1.6}).in_cavity) << "solid is no cavity";
}

}  // namespace
}  // namespace nlg
