#include "scene/model/scene_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "scene/lights/light_options.h"
#include "scene/procedural/level.h"
#include "scene/procedural/procedural.h"
#include "scene/scene_source.h"
#include "tests/datagen/hand_built_scenes.h"
#include "tool/error.h"

namespace nlg {
namespace {

TEST(SceneLightSha256, ChangesWithAllThatLightDependsOn) {
  Scene scene = wallWithHole();
  scene.light.sky_faces.positions = {{0, 9, 0}, {1, 9, 0}, {0, 9, 1}};
  scene.light.sky_faces.triangles = {{0, 1, 2}};
  scene.light.lamps.resize(1);
  scene.light.suns.resize(1);
  scene.light.baked.triangle_page.assign(scene.triangles.size(), BakedLight::kByVertex);
  scene.light.baked.vertex_light.resize(scene.positions.size());
  const std::string whole = sceneLightSha256(scene);
  EXPECT_EQ(sceneLightSha256(scene), whole);
  scene.light.groups.names = {"ab", "c"};
  const std::string grouped = sceneLightSha256(scene);
  EXPECT_NE(grouped, whole);
  EXPECT_EQ(sceneLightSha256(scene, {}), whole);
  const std::function<void(LightGroups&)> groupings[] = {
      [](LightGroups& g) { g.names = {"a", "bc"}; }, [](LightGroups& g) { g.names = {"c", "ab"}; },
      [](LightGroups& g) { g.of_sky = 1; },          [](LightGroups& g) { g.of_shine = 1; },
      [](LightGroups& g) { g.of_baked = 1; },        [](LightGroups& g) { g.of_lamp = {1}; },
  };
  for (const auto& grouping : groupings) {
    Scene other = scene;
    grouping(other.light.groups);
    EXPECT_NE(sceneLightSha256(other), grouped) << &grouping - groupings;
    EXPECT_EQ(sceneLightSha256(other, {}), whole);
  }
  scene.light.groups = {};
  const std::function<void(Scene&)> changes[] = {
      [](Scene& s) { s.positions[3].y += 0.001f; },
      [](Scene& s) { s.light.sky_faces.positions[0].y = 8.0f; },
      [](Scene& s) { s.materials[0].base_color.x = 0.123f; },
      [](Scene& s) { s.materials[0].emissive.x = 0.123f; },
      [](Scene& s) { s.light.sky.ground.x = 1.0f; },
      [](Scene& s) { s.light.sky_faces.shine.resize(1); },
      [](Scene& s) { s.light.lamps[0].radius_m = 1.0f; },
      [](Scene& s) { s.light.suns[0].irradiance.x = 1.0f; },
      [](Scene& s) { s.light.baked.vertex_light[1].x = 1.0f; },
  };
  for (size_t i = 0; i < std::size(changes); ++i) {
    Scene other = scene;
    changes[i](other);
    EXPECT_NE(sceneLightSha256(other), whole) << "change " << i;
    // only the first two are of functions
    EXPECT_EQ(sceneSha256(other) == sceneSha256(scene), i > 1) << "change " << i;
  }
}

// A scene in which nothing shines.
Scene darkScene() { return wallWithHole(); }

TEST(LightOptions, ADarkSceneGetsTheDocumentedSkyAndSunAndSaysSo) {
  Scene scene = darkScene();
  ASSERT_FALSE(hasLight(scene));
  const std::vector<std::string> done = applyLight(scene, {});
  ASSERT_EQ(done.size(), 1u);
  EXPECT_NE(done[0].find("nothing shines"), std::string::npos);
  EXPECT_EQ(scene.light.sky.zenith, defaultSky().zenith);
  ASSERT_EQ(scene.light.suns.size(), 1u);
  EXPECT_EQ(scene.light.suns[0].irradiance, defaultSun().irradiance);
  EXPECT_TRUE(hasLight(scene));
}

void addLamp(Scene& s) { s.light.lamps.push_back({glm::vec3(0.0f), glm::vec3(1.0f), 0.1f}); }
void addSun(Scene& s) { s.light.suns.push_back({{0, 1, 0}, glm::vec3(1.0f)}); }
void addSky(Scene& s) { s.light.sky.ground.g = 0.1f; }
void addBaked(Scene& s) { s.light.baked.triangle_page.resize(s.triangles.size()); }
void addShine(Scene& s) { s.light.sky_faces.shine.push_back(glm::vec3(1.0f)); }
void addSkyFace(Scene& s) { s.light.sky_faces.triangles.push_back({0, 1, 2}); }
void addEmission(Scene& s) { s.materials[s.triangle_material[0]].emissive.b = 1.0f; }

TEST(LightOptions, AFileOfBlenderWithoutLampsSaysHowTheyAreExported) {
  const auto isOpen = [](const Scene&) { return true; };  // and gets a sun by default
  for (const bool has_lamp : {false, true}) {
    Scene scene = darkScene();
    scene.light.writer = LightWriter::blender;
    addEmission(scene);
    if (has_lamp) addLamp(scene);
    const std::vector<std::string> done = applyLight(scene, {}, isOpen);
    const bool says = std::any_of(done.begin(), done.end(),
                                  [](const std::string& line) { return line.find("Punctual Lights") != std::string::npos; });
    EXPECT_EQ(says, !has_lamp);
  }
}

TEST(LightOptions, ASceneThatShinesStaysAsItIs) {
  for (void (*light)(Scene&) : {addEmission, addSky, addLamp, addSun, addShine, addBaked}) {
    Scene scene = darkScene();
    light(scene);
    const std::string before = sceneLightSha256(scene);
    EXPECT_TRUE(hasLight(scene));
    EXPECT_TRUE(applyLight(scene, {}).empty());
    EXPECT_EQ(sceneLightSha256(scene), before);
  }
}

TEST(LightOptions, SkyAndSunReplaceTheScenesOwn) {
  Scene scene = makeProceduralScene("house", 3);
  LightOptions options;
  options.sky = {"1", "2", "3"};
  options.sun = {"90", "30", "4", "5", "6"};
  EXPECT_EQ(applyLight(scene, options).size(), 2u);
  EXPECT_EQ(scene.light.sky.zenith, glm::vec3(1, 2, 3));
  EXPECT_EQ(scene.light.sky.ground, glm::vec3(1, 2, 3));
  ASSERT_EQ(scene.light.suns.size(), 1u);
  EXPECT_NEAR(scene.light.suns[0].to_sun.y, 0.5f, 1e-6f);
  EXPECT_NEAR(scene.light.suns[0].to_sun.z, std::sqrt(0.75f), 1e-6f) << "azimuth turns from x towards z";
  options.sky = {"1", "1", "1", "2", "2", "2", "3", "3", "3"};
  options.sun = {"0"};
  applyLight(scene, options);
  EXPECT_EQ(scene.light.sky.horizon, glm::vec3(2.0f));
  EXPECT_EQ(scene.light.sky.ground, glm::vec3(3.0f));
  EXPECT_TRUE(scene.light.suns.empty());
  Scene dark = darkScene();
  options.sky = {"0"};
  applyLight(dark, options);
  EXPECT_FALSE(hasLight(dark)) << "who asks for darkness gets it";
}

// A scene of Blender's with a sun of 3 W/m² and a lamp of 100 W, in its exporter's units.
Scene sceneOfBlender() {
  Scene scene = darkScene();
  scene.light.unit = {LightUnit::Kind::standard, "a test says so"};
  scene.light.suns.push_back({{0, 1, 0}, glm::vec3(3.0f * 683.0f)});
  scene.light.lamps.push_back({glm::vec3(0.0f), glm::vec3(683.0f * 100.0f / 12.566371f), 0.05f});
  return scene;
}

TEST(LightUnit, LampsOfBlenderAreInWattsWhereEmissionOrASkyStandsBesideThem) {
  const auto sunOf = [](Scene scene, const LightOptions& options, size_t notes) {
    const std::vector<std::string> done = applyLight(scene, options);
    EXPECT_EQ(done.size(), notes) << (done.empty() ? "" : done[0]);
    return scene.light.suns.empty() ? scene.light.lamps[0].intensity.r * 12.566371f : scene.light.suns[0].irradiance.r;
  };
  EXPECT_EQ(sunOf(sceneOfBlender(), {}, 1), 3.0f * 683.0f) << "alone they are as they are";
  Scene emissive = sceneOfBlender();
  emissive.materials[emissive.triangle_material[0]].emissive = glm::vec3(5.0f);
  EXPECT_NEAR(sunOf(emissive, {}, 1), 3.0f, 1e-5f);
  EXPECT_NEAR(sunOf(sceneOfBlender(), {{"1", "1", "1"}, {}}, 2), 3.0f, 1e-5f);
  EXPECT_NEAR(sunOf(sceneOfBlender(), {{}, {"0"}}, 2), 100.0f, 1e-3f) << "the lamp beside the sun that was given";
  EXPECT_EQ(sunOf(emissive, {{}, {}, "file"}, 0), 3.0f * 683.0f);
  EXPECT_NEAR(sunOf(sceneOfBlender(), {{}, {}, "watt"}, 1), 3.0f, 1e-5f);
  EXPECT_THROW(sunOf(emissive, {{}, {}, "lumen"}, 0), UsageError);
  emissive.light.unit = {LightUnit::Kind::raw, "a test says so"};
  EXPECT_EQ(sunOf(emissive, {}, 1), 3.0f * 683.0f) << "raw suns are in emission's unit";
  Scene lamp = emissive;
  lamp.light.suns.clear();
  EXPECT_NEAR(sunOf(lamp, {}, 1), 683.0f * 100.0f / 12.566371f, 1.0f) << "raw lamps are not divided by 4 pi yet";
  emissive.light.unit.kind = LightUnit::Kind::same;
  EXPECT_EQ(sunOf(emissive, {}, 1), 3.0f * 683.0f) << "said, and left";
  emissive.light.unit = {LightUnit::Kind::over_pi, "a test says so"};
  EXPECT_NEAR(sunOf(emissive, {}, 1), 3.14159265f * 3.0f * 683.0f, 1e-2f) << "Godot's, beside emission";
  EXPECT_EQ(sunOf(emissive, {{}, {}, "file"}, 0), 3.0f * 683.0f);
  EXPECT_EQ(unsureUnit(emissive), "");
  emissive.light.unit.kind = LightUnit::Kind::unsure;
  EXPECT_EQ(unsureUnit(emissive), "lamps and suns as they are, as glTF's cd and lux: a test says so");
  EXPECT_EQ(sunOf(emissive, {}, 1), 3.0f * 683.0f) << "said, and left";
  EXPECT_NEAR(sunOf(emissive, {{}, {}, "pi"}, 1), 3.14159265f * 3.0f * 683.0f, 1e-2f);
  Scene alone = sceneOfBlender();
  alone.light.unit.kind = LightUnit::Kind::over_pi;
  EXPECT_EQ(sunOf(alone, {}, 0), 3.0f * 683.0f) << "nothing to compare it with";
  emissive.light.unit = {};
  EXPECT_EQ(sunOf(emissive, {}, 0), 3.0f * 683.0f) << "of another exporter";
}

TEST(LightOptions, AnOpenSceneWithoutLightFromOutsideGetsDaylightUnlessASkyIsGiven) {
  const auto isOpen = [](const Scene&) { return true; };
  const auto isClosed = [](const Scene&) { return false; };
  Scene lamps = darkScene();
  addLamp(lamps);
  Scene scene = lamps;
  EXPECT_TRUE(applyLight(scene, {}, isClosed).empty());
  EXPECT_TRUE(applyLight(scene, {}).empty());
  EXPECT_FALSE(hasLightFromOutside(scene));
  const std::vector<std::string> done = applyLight(scene, {}, isOpen);
  ASSERT_EQ(done.size(), 1u);
  EXPECT_NE(done[0].find("open"), std::string::npos);
  EXPECT_EQ(scene.light.sky.zenith, defaultSky().zenith);
  EXPECT_EQ(scene.light.lamps.size(), 1u);
  Scene night = lamps;
  applyLight(night, {{"0"}, {}}, isOpen);
  EXPECT_FALSE(hasLightFromOutside(night)) << "who asks for a night gets it";
  for (void (*outside)(Scene&) : {addSky, addSun, addSkyFace, addBaked}) {
    Scene lit = lamps;
    outside(lit);
    EXPECT_TRUE(applyLight(lit, {}, isOpen).empty());
  }
}

TEST(LightOptions, IntensityIsAFactorOnAllThatShines) {
  Scene scene = makeProceduralScene("house", 3);
  scene.light.lamps.push_back({glm::vec3(0.0f), glm::vec3(2.0f), 0.1f});
  scene.light.suns = {{{0, 1, 0}, glm::vec3(3.0f)}};
  scene.light.sky.image = {2, 1, {glm::vec3(1.0f), glm::vec3(2.0f)}};
  scene.light.sky_faces.shine = {glm::vec3(5.0f)};
  scene.light.baked.texels = {glm::vec3(6.0f)};
  scene.light.baked.vertex_light = {glm::vec3(7.0f)};
  scene.light.baked.ambient = glm::vec3(8.0f);
  const Scene before = scene;
  LightOptions options;
  options.intensity = 0.5;
  EXPECT_EQ(applyLight(scene, options).size(), 1u);
  const SceneLight &light = scene.light, &old = before.light;
  EXPECT_EQ(light.lamps[0].intensity, 0.5f * old.lamps[0].intensity);
  EXPECT_EQ(light.suns[0].irradiance, 0.5f * old.suns[0].irradiance);
  EXPECT_EQ(light.sky.zenith, 0.5f * old.sky.zenith);
  EXPECT_EQ(light.sky.horizon, 0.5f * old.sky.horizon);
  EXPECT_EQ(light.sky.ground, 0.5f * old.sky.ground);
  EXPECT_EQ(light.sky.image.texels[1], glm::vec3(1.0f));
  EXPECT_EQ(light.sky_faces.shine[0], glm::vec3(2.5f));
  EXPECT_EQ(light.baked.texels[0], glm::vec3(3.0f));
  EXPECT_EQ(light.baked.vertex_light[0], glm::vec3(3.5f));
  EXPECT_EQ(light.baked.ambient, glm::vec3(4.0f));
  for (size_t m = 0; m < scene.materials.size(); ++m) EXPECT_EQ(scene.materials[m].emissive, 0.5f * before.materials[m].emissive);
}

}  // namespace
}  // namespace nlg
