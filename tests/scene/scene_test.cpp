#include "scene/model/scene.h"

#include <gtest/gtest.h>

#include "tests/datagen/hand_built_scenes.h"

namespace nlg {
namespace {

TEST(SceneSha256, ChangesWithAllThatFunctionsDependOn) {
  const Scene scene = wallWithHole();
  const std::string whole = sceneSha256(scene);
  EXPECT_EQ(sceneSha256(scene), whole);
  Scene other = scene;
  other.positions[3].y += 0.001f;
  EXPECT_NE(sceneSha256(other), whole) << "a corner moved";
  other = scene;
  std::swap(other.triangles[0].x, other.triangles[0].y);
  EXPECT_NE(sceneSha256(other), whole) << "a face turned";
  other = scene;
  other.materials[other.triangle_material[0]].double_sided ^= true;
  EXPECT_NE(sceneSha256(other), whole) << "a material that became double-sided";
  other = scene;
  other.objects[0].movable ^= true;
  EXPECT_NE(sceneSha256(other), whole) << "an object that jitter may move";
  other = scene;
  other.origin_m.x += 1.0;
  EXPECT_NE(sceneSha256(other), whole) << "another origin";
  other = scene;
  other.materials[0].base_color.x = 0.123f;
  other.id = "another name";
  EXPECT_EQ(sceneSha256(other), whole) << "colour and name do not count";
}

}  // namespace
}  // namespace nlg
