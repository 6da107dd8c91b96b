#include "light/closure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "light/baked_light.h"
#include "scene/scene_source.h"

namespace nlg {
namespace {

constexpr float kPi = 3.14159265f;

// A floor of 8 x 8 m with a lightmap of 64 x 64 texels that holds what a lamp 1.5 m above its middle sends there, times a factor.
Scene floorUnderALamp(float factor) {
  Scene scene;
  scene.positions = {{-4, 0, -4}, {-4, 0, 4}, {4, 0, 4}, {4, 0, -4}};
  scene.triangles = {{0, 1, 2}, {0, 2, 3}};
  scene.triangle_material = {0, 0};
  scene.materials.emplace_back();
  scene.objects.push_back({"floor", 0, 2, false});
  Lamp lamp;
  lamp.position = {0, 1.5f, 0};
  lamp.intensity = glm::vec3(10.0f);
  scene.light.lamps.push_back(lamp);
  BakedLight& baked = scene.light.baked;
  baked.page_side = 64;
  baked.triangle_page = {0, 0};
  baked.vertex_place = {{0, 0}, {0, 1}, {1, 1}, {1, 0}};
  baked.vertex_light.resize(4);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const glm::vec3 place((static_cast<float>(x) + 0.5f) / 8.0f - 4.0f, 0.0f, (static_cast<float>(y) + 0.5f) / 8.0f - 4.0f);
      const glm::vec3 way = lamp.position - place;
      const float distance = glm::length(way);
      baked.texels.push_back(lamp.intensity * (factor * way.y / (distance * distance * distance) / kPi));
    }
  }
  return scene;
}

TEST(BakedLightLookUp, IsTheTexelAtItsCentreAndTheirMeanBetween) {
  const Scene scene = floorUnderALamp(1.0f);
  const BakedLight& baked = scene.light.baked;
  // triangle 0 has corners (0, 0), (0, 1), (1, 1) of the page: place = (v, u + v)
  const auto at = [&](float x, float y) { return bakedLight(scene, 0, y - x, x).g; };
  EXPECT_NEAR(at(10.5f / 64, 20.5f / 64), baked.texels[20 * 64 + 10].g, 1e-5f);
  EXPECT_NEAR(at(11.0f / 64, 20.5f / 64), 0.5f * (baked.texels[20 * 64 + 10].g + baked.texels[20 * 64 + 11].g), 1e-5f);
  EXPECT_NEAR(at(0.0f, 1.0f), baked.texels[63 * 64].g, 1e-6f) << "the rim holds the last texel's centre";
}

TEST(Closure, IsOneWhereTheLightmapIsWhatTheLampSends) {
  for (const float factor : {1.0f, 0.25f}) {
    const Scene scene = floorUnderALamp(factor);
    const Closure closure = measureClosure(scene, {400, 64, 0.002}, 3);
    ASSERT_EQ(closure.places.size() + closure.in_solid, 400u);
    EXPECT_EQ(closure.in_solid, 0u);
    // texels of 12.5 cm under a lamp 1.5 m away bend by less than 1 %; places stand 2 mm nearer
    EXPECT_GT(closure.correlation, 0.999);
    EXPECT_NEAR(closure.scale, factor, 0.02 * factor);
    for (const ClosurePlace& place : closure.places) {
      EXPECT_EQ(place.surfaces, glm::vec3(0.0f));
      EXPECT_EQ(place.sky, glm::vec3(0.0f));
      // on the rim half a texel, 6 cm, has the last centre's light: 3 · 4 · .0625 / (4² + 1.5²), 4.2 %
      EXPECT_NEAR(place.lamps.g * factor, place.baked.g, 0.05f * place.baked.g + 1e-4f);
    }
  }
}

TEST(Closure, TellsWhatShinesFromWhatReflects) {
  Scene scene = floorUnderALamp(1.0f);
  // a ceiling over all of it, 2 m high, that is lit by vertex and shines
  const auto first = static_cast<uint32_t>(scene.positions.size());
  for (const glm::vec3& p : {glm::vec3(-40, 2, -40), glm::vec3(40, 2, -40), glm::vec3(40, 2, 40), glm::vec3(-40, 2, 40)})
    scene.positions.push_back(p);
  scene.triangles.push_back(glm::uvec3(0, 1, 2) + first);
  scene.triangles.push_back(glm::uvec3(0, 2, 3) + first);
  scene.triangle_material.insert(scene.triangle_material.end(), {1, 1});
  scene.materials.push_back({glm::vec3(0.5f), glm::vec3(2.0f), false});
  scene.light.baked.triangle_page.insert(scene.light.baked.triangle_page.end(), {BakedLight::kByVertex, BakedLight::kByVertex});
  scene.light.baked.vertex_place.resize(8);
  scene.light.baked.vertex_light.resize(8, glm::vec3(3.0f));
  const Closure closure = measureClosure(scene, {50, 1024, 0.002}, 3);
  ASSERT_GT(closure.places.size(), 40u);
  for (const ClosurePlace& place : closure.places) {
    // the ceiling is nearly all of the hemisphere: beyond its rim, 36 m away, lie less than (2 / 36)² of it
    EXPECT_NEAR(place.surfaces.g, 1.5f, 0.02f) << "light 3 times a colour of .5";
    EXPECT_NEAR(place.emission.g, 2.0f, 0.1f);
  }
}

// A level that kept its lamps, where its package is installed: what it holds must explain its own lightmaps. .56 with its package
// alone, which has none of the scripts of what shines; .93 with all of its game's archives (docs/theory/light.md). Any of them may be
// installed here.
TEST(Closure, AnInstalledLevelExplainsItsLightmaps) {
  const char* root = std::getenv("NLG_ARCHIVE_ROOT");
  const std::string path = std::string(root != nullptr ? root : "") + "/usr/share/games/openarena/baseoa";
  if (!std::filesystem::is_directory(path)) GTEST_SKIP() << "no levels installed";
  const SceneSource source = loadScene(path + ":kaos");
  const Closure closure = measureClosure(source.scene, {400, 256, 0.02}, 1);
  EXPECT_GT(closure.correlation, 0.45);
  EXPECT_GT(closure.scale, 0.5);
  EXPECT_LT(closure.scale, 1.5);
}

}  // namespace
}  // namespace nlg
