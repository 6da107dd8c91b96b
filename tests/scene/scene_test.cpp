#include "scene/model/scene.h"

#include <gtest/gtest.h>

#include <functional>

#include "tests/datagen/hand_built_scenes.h"

namespace nlg {
namespace {

TEST(SceneSha256, ChangesWithAllThatFunctionsDependOn) {
  const Scene scene = wallWithHole();
  const std::string whole = sceneSha256(scene);
  EXPECT_EQ(sceneSha256(scene), whole);
  const std::pair<const char*, std::function<void(Scene&)>> changes[] = {
      {"a corner moved", [](Scene& s) { s.positions[3].y += 0.001f; }},
      {"a face turned", [](Scene& s) { std::swap(s.triangles[0].x, s.triangles[0].y); }},
      {"a material that became double-sided", [](Scene& s) { s.materials[s.triangle_material[0]].double_sided ^= true; }},
      {"an object that jitter may move", [](Scene& s) { s.objects[0].movable ^= true; }},
      {"another origin", [](Scene& s) { s.origin_m.x += 1.0; }}};
  Scene other = scene;
  for (const auto& [what, change] : changes) {
    change(other = scene);
    EXPECT_NE(sceneSha256(other), whole) << what;
  }
  other = scene;
  other.materials[0].base_color.x = 0.123f;
  other.id = "another name";
  EXPECT_EQ(sceneSha256(other), whole) << "colour and name do not count";
}

}  // namespace
}  // namespace nlg
