#include "light/air.h"

#include <gtest/gtest.h>

#include "datagen/visibility/support_visibility.h"
#include "runtime_eval/numbers/random.h"
#include "scene/procedural/procedural.h"
#include "tests/datagen/hand_built_scenes.h"
#include "tests/scene/windowed_room.h"

namespace nlg {
namespace {

// A yard of four walls and a floor that look inward, 4 m wide and 3 m high, under a lid of sky: all that a level's file has of it.
Scene yardUnderSky() {
  SceneOfFaces faces;
  faces.addBox({-2, 0, -2}, {2, 3, 2}, true);
  Scene scene = faces.finish();
  const auto isLid = [&](const glm::uvec3& t) {
    return scene.positions[t.x].y == 3.0f && scene.positions[t.y].y == 3.0f && scene.positions[t.z].y == 3.0f;
  };
  SkyFaces& sky = scene.light.sky_faces;
  sky.positions = scene.positions;
  std::vector<glm::uvec3> kept;
  for (const glm::uvec3& triangle : scene.triangles) (isLid(triangle) ? sky.triangles : kept).push_back(triangle);
  EXPECT_EQ(sky.triangles.size(), 2u);
  scene.triangles = kept;
  scene.triangle_material.resize(kept.size());
  scene.objects[0].triangle_count = static_cast<uint32_t>(kept.size());
  return scene;
}

TEST(Air, IsInARoomAndNotInItsWalls) {
  SceneOfFaces faces;
  faces.addRoom({-2, 0, -2}, {2, 3, 2}, 0.2f);
  const Scene scene = faces.finish();
  const RayScene rays(scene);
  EXPECT_TRUE(isInAir(rays, {0.3, 1.5, -0.4}));
  EXPECT_TRUE(isInAir(rays, {1.99, 1.5, -0.4}));
  EXPECT_FALSE(isInAir(rays, {2.1, 1.5, -0.4}));
  EXPECT_TRUE(isInAir(rays, {2.3, 1.5, -0.4})) << "outside a house is air";
}

TEST(Air, IsNotInTheHollowsOfAWall) {
  Scene scene = windowedRoom(true);
  const glm::dvec3 in_wall(1.3, 1.5, kRoomHigh.z + 0.1), in_room(1.3, 1.5, kRoomHigh.z - 0.1);
  EXPECT_FALSE(isInAir(RayScene(scene), in_wall));
  EXPECT_TRUE(isInAir(RayScene(scene), in_room));
  scene.cavity_m = 0.0;
  EXPECT_TRUE(isInAir(RayScene(scene), in_wall)) << "all air counts";
}

TEST(Air, EndsBehindTheSky) {
  const Scene scene = yardUnderSky();
  const RayScene rays(scene);
  EXPECT_TRUE(isInAir(rays, {0.3, 1.5, -0.4}));
  EXPECT_TRUE(isInAir(rays, {0.3, 2.99, -0.4}));
  // just above the lid: rays down go through it and meet walls and floor from their fronts
  const glm::dvec3 behind(0.3, 3.05, -0.4);
  EXPECT_FALSE(solidVote(rays, behind).solid()) << "without the sky this is air";
  EXPECT_FALSE(isInAir(rays, behind));
}

// Rays that are not cast change nothing, in whatever order places come.
TEST(Air, IsWhatAWholeVoteSays) {
  Random random(5);
  for (const Scene& scene : {yardUnderSky(), makeProceduralScene("house", 3), makeProceduralScene("apartment", 2)}) {
    const RayScene rays(scene);
    AirVoter voter(rays);
    const Bounds bounds = sceneBounds(scene);
    int air = 0;
    for (int i = 0; i < 2000; ++i) {
      const glm::dvec3 share(random.uniform(), random.uniform(), random.uniform());
      const glm::dvec3 place = glm::mix(glm::dvec3(bounds.min) - 1.0, glm::dvec3(bounds.max) + 1.0, share);
      const SolidVote vote = solidVoteWithSky(rays, place);
      const bool is_outside = rays.hasSkyFaces() && 2 * vote.nothing > kSolidVoteRays;
      const bool is_air = !is_outside && !vote.solid() && !vote.disputed();
      ASSERT_EQ(voter.isAir(place), is_air) << scene.id << ": " << place.x << ", " << place.y << ", " << place.z;
      ASSERT_EQ(voter.meetsNoFront(place), vote.front == 0 && (is_outside || vote.unanimous())) << scene.id;
      air += is_air;
    }
    EXPECT_GT(air, 100) << scene.id;
    EXPECT_LT(air, 1990) << scene.id;
  }
}

}  // namespace
}  // namespace nlg
