#include "datagen/visibility/cavity.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "datagen/weighting/weighting_builder.h"
#include "runtime_eval/numbers/random.h"
#include "tests/scene/windowed_room.h"
#include "tool/parallel_for.h"

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
  // the end at x = 4 last
  auto sides = boxSides({0, 0, 0}, {4, 0.3f, 0.3f});
  std::rotate(sides.begin(), sides.begin() + 2, sides.end());
  Scene duct = sheets();
  for (size_t side = 0; side < 6; ++side) {
    if (side == 5) {
      EXPECT_LE(inCavity(duct, glm::dvec3(0), {4, 0.3, 0.3}), kFew);
    }
    const auto& [a, b, c, d] = sides[side];
    addQuad(duct, a, b - a, d - a);
  }
  EXPECT_EQ(inCavity(duct, glm::dvec3(0), {4, 0.3, 0.3}), kPlaces);
}

// A millimetre all round below a wall's sheet: rays pass it, nobody does.
TEST(Cavity, DoesNotMindACrack) {
  Scene wall = sheets();
  addRoom(wall, {-2, 0, -2}, {2, 3, 2});
  addQuad(wall, {-2, 0.001f, -1.8f}, {4, 0, 0}, {0, 2.999f, 0});
  EXPECT_GE(inCavity(wall, {-2, 0, -2}, {2, 3, -1.8}), kPlaces - kFew);
}

// A wall of sheets in a room, 6 m long and 20 cm thick, with a hole at the foot of one end.
Scene hollowWall(float hole_height_m, bool faces_out) {
  Scene scene = sceneOfMaterial(false);
  scene.cavity_m = 0.5;
  addRoom(scene, {-1, 0, -3}, {9, 2.5f, 3});
  const size_t first = scene.triangles.size();
  addBox(scene, {0, 0.01f, 0}, {6, 2.49f, 0.2f});
  scene.triangles.erase(scene.triangles.end() - 4, scene.triangles.end() - 2);  // the end at x = 6
  scene.triangle_material.resize(scene.triangles.size());
  addQuad(scene, {6, 0.01f + hole_height_m, 0}, {0, 2.48f - hole_height_m, 0}, {0, 0, 0.2f});
  for (size_t t = first; !faces_out && t < scene.triangles.size(); ++t) std::swap(scene.triangles[t].y, scene.triangles[t].z);
  return scene;
}

int inWall(const Scene& wall) { return inCavity(wall, {0.001, 0.011, 0.001}, {5.999, 2.489, 0.199}); }

TEST(Cavity, IsAllOfAWallOrNothingOfIt) {
  for (const bool faces_out : {true, false}) {
    EXPECT_EQ(inWall(hollowWall(0.0f, faces_out)), kPlaces);
    EXPECT_EQ(inWall(hollowWall(0.005f, faces_out)), kPlaces) << "a crack";
    // wider than a cell of the lattice: some link leads through
    EXPECT_EQ(inWall(hollowWall(0.2f, faces_out)), 0) << "a hole of 20 cm";
    for (const float height_m : {0.01f, 0.02f, 0.05f, 0.1f}) {
      const int count = inWall(hollowWall(height_m, faces_out));
      EXPECT_TRUE(count == 0 || count == kPlaces) << count << " with a hole of " << height_m << " m";
    }
  }
}

TEST(Cavity, IsTheSameForAllThatSeeEachOther) {
  // shelves and slats in a room, with pockets between them out of which no way of the lattice leads
  Scene room = sheets();
  addRoom(room, {-2, 0, -2}, {2, 2.5f, 2});
  for (int i = 0; i < 12; ++i) addBox(room, {-1.9f, 0.1f + 0.17f * i, -1.9f}, {0.3f, 0.13f + 0.17f * i, -1.3f});
  for (int i = 0; i < 20; ++i) addBox(room, {0.5f + 0.07f * i, 0, -1.9f}, {0.54f + 0.07f * i, 2, -1.5f});
  const RayScene rays(room);
  Random random(5);
  const auto within = [&](double reach) {
    return glm::dvec3(random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach));
  };
  int pair_count = 0, differ_count = 0;
  for (int i = 0; i < 4 * kPlaces; ++i) {
    const glm::dvec3 place = glm::dvec3(0, 1.1, -1.6) + within(1.0) * glm::dvec3(1.9, 1.1, 0.3), other = place + within(0.2);
    if (rays.isOpaqueBetween(glm::vec3(place), glm::vec3(other))) continue;
    ++pair_count;
    differ_count += isInCavity(rays, place) != isInCavity(rays, other);
  }
  EXPECT_GT(pair_count, kPlaces);
  EXPECT_EQ(differ_count, 0);
}

// Whoever asks first, and however many ask.
TEST(Cavity, DoesNotDependOnWhatWasAskedBefore) {
  const Scene room = windowedRoom(true);
  std::vector<glm::dvec3> places;
  Random random(3);
  for (int i = 0; i < kPlaces; ++i)
    places.emplace_back(random.uniform(-2.2, 2.2), random.uniform(-0.2, 2.7), random.uniform(-1.7, 1.7));
  const RayScene forward(room), backward(room), threaded(room);
  std::vector<char> one(places.size()), other(places.size()), third(places.size());
  for (size_t i = 0; i < places.size(); ++i) one[i] = isInCavity(forward, places[i]);
  for (size_t i = places.size(); i-- > 0;) other[i] = isInCavity(backward, places[i]);
  parallelFor(places.size(), 4, [&](uint64_t i, int) { third[i] = isInCavity(threaded, places[i]); });
  EXPECT_EQ(one, other);
  EXPECT_EQ(one, third);
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
  const Scene hollow = windowedRoom(true), solid = windowedRoom(false);
  const RayScene hollow_rays(hollow), solid_rays(solid);
  WeightingBuilder of_hollow(hollow_rays, {}), of_solid(solid_rays, {});
  for (const glm::dvec3& probe : {glm::dvec3(1.0, 1.3, 1.2), glm::dvec3(-1.7, 0.3, -1.3), glm::dvec3(0.9, 1.3, 2.0)}) {
    GeneratedFunction hollow_function, solid_function;
    ASSERT_EQ(of_hollow.build(probe, 1.0f, &hollow_function), ProbeOutcome::function);
    ASSERT_EQ(of_solid.build(probe, 1.0f, &solid_function), ProbeOutcome::function);
    EXPECT_EQ(hollow_function.valid, solid_function.valid) << "around " << probe.x;
  }
  const SolidVote vote = voteAt(hollow_rays, {1.2, 1.3, 1.6});
  EXPECT_TRUE(vote.solid());
  EXPECT_TRUE(vote.in_cavity);
  EXPECT_FALSE(voteAt(solid_rays, {1.2, 1.3, 1.6}).in_cavity) << "solid is no cavity";
}

}  // namespace
}  // namespace nlg
