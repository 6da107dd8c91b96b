#include "scene/scene_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "scene/light_options.h"
#include "scene/procedural.h"
#include "scene/procedural/daylight.h"
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
  const std::function<void(Scene&)> changes[] = {
      [](Scene& s) { s.positions[3].y += 0.001f; },
      [](Scene& s) { s.materials[0].base_color.x = 0.123f; },
      [](Scene& s) { s.materials[0].emissive.x = 0.123f; },
      [](Scene& s) { s.light.sky.ground.x = 1.0f; },
      [](Scene& s) { s.light.sky_faces.positions[0].y = 8.0f; },
      [](Scene& s) { s.light.sky_faces.shine.resize(1); },
      [](Scene& s) { s.light.lamps[0].radius_m = 1.0f; },
      [](Scene& s) { s.light.suns[0].irradiance.x = 1.0f; },
      [](Scene& s) { s.light.baked.vertex_light[1].x = 1.0f; },
  };
  for (size_t i = 0; i < std::size(changes); ++i) {
    Scene other = scene;
    changes[i](other);
    EXPECT_NE(sceneLightSha256(other), whole) << "change " << i;
    // only the first one moves geometry
    EXPECT_EQ(sceneSha256(other) == sceneSha256(scene), i > 0) << "change " << i;
  }
}

TEST(Sky, IsAGradientFromTheHorizonUp) {
  const Sky sky{glm::vec3(4.0f), glm::vec3(2.0f), glm::vec3(1.0f)};
  EXPECT_FLOAT_EQ(sky.radiance({0, 1, 0}).r, 4.0f);
  EXPECT_FLOAT_EQ(sky.radiance({1, 0, 0}).r, 2.0f);
  EXPECT_FLOAT_EQ(sky.radiance({0.8f, 0.6f, 0}).r, 3.2f);
  EXPECT_FLOAT_EQ(sky.radiance({0.8f, -0.6f, 0}).r, 1.0f);
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

TEST(LightOptions, ASceneThatShinesStaysAsItIs) {
  const std::function<void(Scene&)> lights[] = {
      [](Scene& s) { s.materials[s.triangle_material[0]].emissive.b = 1.0f; },
      [](Scene& s) { s.light.sky.ground.g = 0.1f; },
      [](Scene& s) {
        s.light.lamps.push_back({glm::vec3(0.0f), glm::vec3(1.0f), 0.1f});
      },
      [](Scene& s) {
        s.light.suns.push_back({{0, 1, 0}, glm::vec3(1.0f)});
      },
      [](Scene& s) { s.light.sky_faces.shine.push_back(glm::vec3(1.0f)); },
      [](Scene& s) { s.light.baked.triangle_page.resize(s.triangles.size()); },
  };
  for (const auto& light : lights) {
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

TEST(LightOptions, RefusesWhatIsNoLight) {
  Scene scene = darkScene();
  const std::vector<std::vector<std::string>> skies = {
      {"1"}, {"1", "2"}, {"1", "2", "x"}, {"1", "2", ""}, {"1", "2", "nan"}, {"1", "2", "-3"}, {"1", "2", "1e13"}};
  for (const std::vector<std::string>& sky : skies) EXPECT_THROW(applyLight(scene, {sky, {}}), UsageError) << sky.back();
  const std::vector<std::vector<std::string>> suns = {
      {"1", "2", "3"}, {"0", "91", "1", "1", "1"}, {"400", "0", "1", "1", "1"}, {"0", "0", "1", "1", "-1"}};
  for (const std::vector<std::string>& sun : suns) EXPECT_THROW(applyLight(scene, {{}, sun}), UsageError) << sun.back();
}

double emittingArea(const Scene& scene) {
  double area = 0.0;
  for (size_t t = 0; t < scene.triangles.size(); ++t) {
    if (scene.materials[scene.triangle_material[t]].emissive == glm::vec3(0.0f)) continue;
    const glm::vec3 a = scene.positions[scene.triangles[t].x];
    area += 0.5 * glm::length(glm::cross(scene.positions[scene.triangles[t].y] - a, scene.positions[scene.triangles[t].z] - a));
  }
  return area;
}

TEST(BuiltInScenes, AreReachableByName) {
  EXPECT_EQ(loadScene("cornell").id, "cornell_0");
  EXPECT_EQ(loadScene("cornell:0").scene.positions, loadScene("cornell").scene.positions);
  EXPECT_EQ(loadScene("two_rooms:1").family, "two_rooms");
  EXPECT_THROW(loadScene("cornell:1"), UsageError);
  EXPECT_THROW(loadScene("two_rooms:2"), UsageError);
  EXPECT_THROW(loadScene("two_rooms:x"), UsageError);
}

TEST(BuiltInScenes, TheCornellBoxIsTwoMetresInsideWithOneLamp) {
  const Scene scene = loadScene("cornell").scene;
  const Bounds bounds = sceneBounds(scene);
  // rounded to 1/256 m
  EXPECT_NEAR(bounds.max.x - bounds.min.x, 2.2f, 0.01f);
  EXPECT_NEAR(bounds.max.y - bounds.min.y, 2.2f, 0.01f);
  EXPECT_NEAR(emittingArea(scene), 0.47 * 0.38, 0.01) << "the panel's lower side alone";
  // red is seen on the left, green on the right
  for (size_t t = 0; t < scene.triangles.size(); ++t) {
    const glm::vec3 colour = scene.materials[scene.triangle_material[t]].base_color;
    const float x = scene.positions[scene.triangles[t].x].x;
    const bool is_red = colour.r > 5.0f * colour.g, is_green = colour.g > 2.0f * colour.r;
    EXPECT_TRUE(!is_red || x < -0.99f) << x;
    EXPECT_TRUE(!is_green || x > 0.99f) << x;
  }
}

TEST(BuiltInScenes, TheLampOfTwoRoomsHangsInTheLeftOne) {
  for (const std::string& request : {std::string("two_rooms:0"), std::string("two_rooms:1")}) {
    const Scene scene = loadScene(request).scene;
    EXPECT_GT(emittingArea(scene), 0.3) << request;
    for (size_t t = 0; t < scene.triangles.size(); ++t) {
      if (scene.materials[scene.triangle_material[t]].emissive == glm::vec3(0.0f)) continue;
      for (int k = 0; k < 3; ++k) {
        EXPECT_LT(scene.positions[scene.triangles[t][k]].x, -0.1f);
        EXPECT_GT(scene.positions[scene.triangles[t][k]].y, 2.4f);
      }
    }
  }
  EXPECT_GT(loadScene("two_rooms:1").scene.triangles.size(), loadScene("two_rooms:0").scene.triangles.size()) << "the door";
}

TEST(Daylight, IsTheSameForASeedAndDayOrNightBySeed) {
  int nights = 0;
  for (uint64_t seed = 0; seed < 300; ++seed) {
    const Daylight daylight = drawDaylight(seed);
    EXPECT_EQ(daylight.sky.zenith, drawDaylight(seed).sky.zenith);
    nights += daylight.suns.empty();
    for (const Sun& sun : daylight.suns) {
      EXPECT_NEAR(glm::length(sun.to_sun), 1.0f, 1e-5f);
      EXPECT_GT(sun.to_sun.y, std::sin(0.26f));
      EXPECT_LT(sun.to_sun.y, std::sin(1.14f));
    }
  }
  // a third of 300, and five standard deviations of that: 5 sqrt(300 · 1/3 · 2/3) = 41
  EXPECT_NEAR(nights, 100, 41);
}

TEST(ProceduralLight, EveryFurnishedFamilyHasLampsAndEveryLevelASky) {
  for (const std::string& family : proceduralFamilies()) {
    const Scene scene = makeProceduralScene(family, 3);
    EXPECT_TRUE(hasLight(scene)) << family;
    EXPECT_GT(scene.light.sky.horizon.g, 0.0f) << family;
  }
  EXPECT_GT(emittingArea(makeProceduralScene("house", 3)), 0.5);
  EXPECT_GT(emittingArea(makeProceduralScene("apartment", 3)), 0.5);
}

TEST(ProceduralLight, WallsOfApartmentsAreAsThinAsHousesHaveThem) {
  const Scene scene = makeProceduralScene("apartment", 3);
  int thin_count = 0;
  for (const SceneObject& object : scene.objects) {
    if (object.name != "inner wall" && object.name != "hall wall") continue;
    const Bounds bounds = objectBounds(scene, object);
    const glm::vec3 size = bounds.max - bounds.min;
    EXPECT_NEAR(std::min(size.x, size.z), 0.1f, 0.005f) << object.name;
    ++thin_count;
  }
  EXPECT_GT(thin_count, 0);
}

}  // namespace
}  // namespace nlg
