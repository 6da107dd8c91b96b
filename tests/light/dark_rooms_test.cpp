#include "light/standing.h"

#include <gtest/gtest.h>

#include "datagen/probes/probe_placement.h"
#include "tests/datagen/hand_built_scenes.h"

namespace nlg {
namespace {

// Two rooms beside each other, at x below and above 0, of 3 x 3 m.
Scene twoRooms(float height_m, bool has_wall) {
  SceneOfFaces faces;
  if (has_wall) {
    faces.addBox({-3, 0, 0}, {-0.05f, height_m, 3}, true);
    faces.addBox({0.05f, 0, 0}, {3, height_m, 3}, true);
  } else {
    faces.addBox({-3, 0, 0}, {3, height_m, 3}, true);
  }
  faces.addBox({-3.1f, -0.1f, -0.1f}, {3.1f, height_m + 0.1f, 3.1f});
  return faces.finish();
}

// What is dark is what lies above x = 0.
std::vector<DarkRoom> darkRoomsOf(const Scene& scene) {
  const RayScene rays(scene);
  const LightTransport transport(scene, rays);
  ProbePlacementOptions placement;
  placement.spacing_min_m = placement.spacing_max_m = 0.5;
  const ProbeTree tree = placeProbes(scene, placement, 1);
  const AirPlaces air = findAirPlaces(rays, tree, {}, 1);
  std::vector<uint8_t> is_dark;
  for (const glm::dvec3& place : air.places) is_dark.push_back(place.x > 0.0);
  return findDarkRooms(transport, tree, air, is_dark);
}

TEST(DarkRooms, AreThoseOfWhichAllAirIsDark) {
  const std::vector<DarkRoom> rooms = darkRoomsOf(twoRooms(2.5f, true));
  ASSERT_EQ(rooms.size(), 1u);
  EXPECT_NEAR(rooms[0].volume_m3, 2.95 * 2.5 * 3.0, 2.0);
  EXPECT_TRUE(rooms[0].eye_m.x > 0.05 && rooms[0].eye_m.x < 3.0) << rooms[0].eye_m.x;
  EXPECT_NEAR(rooms[0].eye_m.y, 1.6, 1e-3);
  EXPECT_TRUE(darkRoomsOf(twoRooms(2.5f, false)).empty()) << "half of a room is dark, and touches the other half";
}

TEST(DarkRooms, AreNotWhereNobodyCanStand) {
  EXPECT_TRUE(darkRoomsOf(twoRooms(1.0f, true)).empty()) << "too low";
  SceneOfFaces ground;
  ground.addBox({-3, -0.1f, 0}, {3, 0, 3});
  ground.addBox({-0.05f, 0, 0}, {0.05f, 3, 3});
  EXPECT_TRUE(darkRoomsOf(ground.finish()).empty()) << "nothing is above";
}

// Where all is dark that lies above x = 0: how much of it nobody sees.
double unseenShare(const Scene& scene) {
  const RayScene rays(scene);
  const LightTransport transport(scene, rays);
  ProbePlacementOptions placement;
  placement.spacing_min_m = placement.spacing_max_m = 0.5;
  const AirPlaces air = findAirPlaces(rays, placeProbes(scene, placement, 1), {}, 1);
  std::vector<uint8_t> is_dark;
  // not what is outside of both rooms
  for (const glm::dvec3& p : air.places)
    is_dark.push_back(p.x > 0.0 && p.x < 2.9 && p.y > 0.0 && p.y < 2.5 && p.z > 0.0 && p.z < 3.0);
  const std::vector<uint8_t> is_unseen = findUnseenDark(transport, air.places, is_dark, 0.5);
  double dark = 0.0, unseen = 0.0;
  for (size_t p = 0; p < is_dark.size(); ++p) {
    EXPECT_LE(is_unseen[p], is_dark[p]) << "what is lit is seen";
    dark += is_dark[p];
    unseen += is_unseen[p];
  }
  return unseen / dark;
}

TEST(UnseenDark, IsAllOfWhereNobodyCanStandAndNothingOfARoom) {
  EXPECT_EQ(unseenShare(twoRooms(1.0f, true)), 1.0) << "too low to stand in";
  EXPECT_EQ(unseenShare(twoRooms(2.5f, true)), 0.0) << "a dark room";
}

// Beside a lit room a yard without a roof, 3 m deep, or nothing at all.
TEST(UnseenDark, IsTheVoidAndNotAYardAtNight) {
  for (const bool has_yard : {false, true}) {
    SceneOfFaces faces;
    faces.addBox({-3, 0, 0}, {-0.05f, 2.5f, 3}, true);
    faces.addBox({-3.1f, -0.1f, -0.1f}, {-0.02f, 3, 3.1f});
    if (has_yard) {
      faces.addQuad({-0.02f, 0, 0}, {-0.02f, 0, 3}, {2.9f, 0, 3}, {2.9f, 0, 0}, Sides::two);
      faces.addQuad({2.9f, 0, 0}, {2.9f, 0, 3}, {2.9f, 3, 3}, {2.9f, 3, 0}, Sides::two);
      for (const float z : {0.0f, 3.0f}) faces.addQuad({-0.02f, 0, z}, {2.9f, 0, z}, {2.9f, 3, z}, {-0.02f, 3, z}, Sides::two);
    } else {
      faces.addTriangle({2.9f, 0, 0}, {2.9f, 0.1f, 0}, {2.9f, 0, 0.1f}, Sides::two);
    }
    EXPECT_EQ(unseenShare(faces.finish()), has_yard ? 0.0 : 1.0);
  }
}

}  // namespace
}  // namespace nlg
