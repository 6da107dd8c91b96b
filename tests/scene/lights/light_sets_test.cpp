// How light sets are asked for, and what of two scenes' geometry differs.
#include "scene/lights/light_sets.h"

#include <gtest/gtest.h>

namespace nlg {
namespace {

using Texts = std::vector<std::string>;

TEST(LightSets, TakeWhatAllHaveUnlessTheySayOtherwise) {
  LightOptions of_all;
  of_all.sky = {"1", "1", "1"};
  of_all.light_groups = "kind";
  const std::vector<LightSet> sets =
      lightSetsFrom({"day", "night=my levels/a=b.glb  sky=.1,.1,.3 sun=0", "dusk intensity=.5 light_groups=one"}, of_all);
  ASSERT_EQ(sets.size(), 3u);
  EXPECT_EQ(sets[0].name, "day");
  EXPECT_EQ(sets[0].scene, "");
  EXPECT_EQ(sets[0].options.sky, of_all.sky);
  EXPECT_EQ(sets[1].name, "night");
  EXPECT_EQ(sets[1].scene, "my levels/a=b.glb");
  EXPECT_EQ(sets[1].options.sky, (Texts{".1", ".1", ".3"}));
  EXPECT_EQ(sets[1].options.sun, Texts{"0"});
  EXPECT_EQ(sets[1].options.light_groups, "kind");
  EXPECT_EQ(sets[2].name, "dusk");
  EXPECT_EQ(sets[2].options.intensity, 0.5);
  EXPECT_EQ(sets[2].options.light_groups, "one");
}

TEST(LightSets, NameTheGroupsOfAGrid) {
  SceneSource source;
  source.scene.light.groups.names = {"sky", "Lamp"};
  EXPECT_EQ(lightGroupNames(source), source.scene.light.groups.names);
  EXPECT_EQ(firstGroupCount(source), 2u);
  const std::string one = lightSha256(source);
  source.light_sets = {"day", "night"};
  source.lit_otherwise.resize(1);
  EXPECT_EQ(lightGroupNames(source), (Texts{"day/sky", "day/Lamp", "night"}));
  EXPECT_EQ(firstGroupCount(source), 2u);
  const std::string two = lightSha256(source);
  EXPECT_NE(two, one);
  source.lit_otherwise[0].light.sky = defaultSky();
  EXPECT_NE(lightSha256(source), two);
}

TEST(GeometryDifference, SaysWhatFunctionsCanSee) {
  const Scene room = loadScene("cornell:0").scene;
  EXPECT_EQ(geometryDifference(room, room), "");
  Scene painted = room;
  painted.light.sky = defaultSky();
  for (Material& material : painted.materials) material.base_color = material.emissive = glm::vec3(0.25f);
  EXPECT_EQ(geometryDifference(room, painted), "") << "light is none of it";
  Scene moved = room;
  moved.positions[room.triangles[5].y].x += 0.5f;
  EXPECT_NE(geometryDifference(room, moved).find("a corner of '"), std::string::npos) << geometryDifference(room, moved);
  Scene thin = room;
  thin.materials[room.triangle_material[0]].double_sided = true;
  EXPECT_NE(geometryDifference(room, thin).find("two sides"), std::string::npos) << geometryDifference(room, thin);
  Scene less = room;
  less.triangles.pop_back();
  EXPECT_NE(geometryDifference(room, less).find("triangles, not"), std::string::npos) << geometryDifference(room, less);
  Scene boxed = room;
  boxed.extent = ExtentBox{};
  EXPECT_NE(geometryDifference(room, boxed), "");
}

}  // namespace
}  // namespace nlg
