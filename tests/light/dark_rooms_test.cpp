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

}  // namespace
}  // namespace nlg
