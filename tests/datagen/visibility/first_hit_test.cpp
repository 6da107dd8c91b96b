#include <gtest/gtest.h>

#include "datagen/visibility/ray_scene.h"
#include "tests/datagen/hand_built_scenes.h"

namespace nlg {
namespace {

TEST(RaySceneFirstHit, TellsDistanceNormalAndMaterialFromBothSides) {
  const RayScene rays(thinWall(Sides::two));
  for (const float side : {-1.0f, 1.0f}) {
    const auto hit = rays.firstHit({0.31f + 2.0f * side, 0.1f, 0.2f}, {-0.5f * side, 0, 0});
    ASSERT_TRUE(hit.has_value());
    EXPECT_NEAR(hit->distance, 4.0f, 1e-5f);  // in lengths of the direction
    EXPECT_EQ(hit->normal, glm::vec3(side, 0, 0));
    EXPECT_EQ(hit->material, 1u);
  }
}

TEST(RaySceneFirstHit, IsNothingWhereNothingStands) {
  const RayScene rays(infiniteWall());
  EXPECT_FALSE(rays.firstHit({0, 0, 0}, {-1, 0, 0}).has_value());
  EXPECT_TRUE(rays.firstHit({0, 0, 0}, {1, 0, 0}).has_value());
}

}  // namespace
}  // namespace nlg
