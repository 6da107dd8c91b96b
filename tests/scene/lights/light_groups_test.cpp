// Which of a scene's lights are kept apart, by kind, by name and by what the file's author says.
#include "scene/lights/light_groups.h"

#include <gtest/gtest.h>

#include "scene/lights/light_options.h"
#include "tool/error.h"

namespace nlg {
namespace {

using Names = std::vector<std::string>;

// A sky, a sun, three lamps and a material that shines, of which one lamp has a group of its own.
Scene manyLights() {
  Scene scene;
  scene.positions.resize(3);
  scene.triangles = {{0, 1, 2}};
  scene.triangle_material = {1};
  scene.materials.resize(3);
  scene.materials[1].emissive = scene.materials[2].emissive = glm::vec3(1.0f);
  scene.materials[1].label.name = "screen";
  scene.materials[2].label.name = "of no triangle";
  scene.light.sky = defaultSky();
  scene.light.suns = {defaultSun()};
  scene.light.lamps.resize(3);
  scene.light.lamp_labels = {{"Desk", ""}, {"Desk.001", ""}, {"Torch", "fire"}};
  return scene;
}

TEST(LightGroups, GoByKindOrByNameWithoutBlendersNumbersAndByWhatTheAuthorSays) {
  const auto groupsBy = [](const char* what) {
    Scene scene = manyLights();
    groupLights(what, "", &scene);
    return scene.light.groups;
  };
  const LightGroups one = groupsBy("one"), kind = groupsBy("kind"), name = groupsBy("name");
  EXPECT_TRUE(one.names.empty());
  EXPECT_EQ(one.count(), 1u);
  EXPECT_EQ(kind.names, (Names{"sky", "sun", "lamps", "fire", "emission"}));
  EXPECT_EQ(kind.of_material[1], 4);
  EXPECT_EQ(name.names, (Names{"sky", "sun", "Desk", "fire", "screen"}));
  for (const LightGroups& groups : {kind, name}) EXPECT_EQ(groups.of_lamp, (std::vector<uint8_t>{2, 2, 3}));
}

TEST(LightGroups, AreNamedByTheStateOfLight) {
  Scene scene = manyLights();
  groupLights("kind", "night", &scene);
  EXPECT_EQ(scene.light.groups.names, (Names{"night/sky", "night/sun", "night/lamps", "night/fire", "night/emission"}));
  EXPECT_TRUE(scene.light.groups.areMany());
  groupLights("one", "night", &scene);
  EXPECT_EQ(scene.light.groups.names, Names{"night"});
  EXPECT_FALSE(scene.light.groups.areMany());
  for (const char* unfit : {"a b", "a/b", "a,b"}) EXPECT_THROW(groupLights("one", unfit, &scene), UsageError) << unfit;
}

}  // namespace
}  // namespace nlg
