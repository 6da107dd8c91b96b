// Light of a scene of which it is known what every probe must hold.
#include "bake/light_bake.h"

#include <gtest/gtest.h>

#include <numeric>

#include "light/air.h"
#include "light/methods/method_set.h"
#include "nlg/look_up.h"
#include "runtime_eval/numbers/random.h"
#include "tests/temporary_folder.h"
#include "tool/error.h"
#include "validate/light/asked_bakes.h"

namespace nlg {
namespace {

constexpr float kPi = 3.14159265f;

BakeOptions roomOptions(const std::string& light, int threads = 2) {
  BakeOptions options;
  options.spacing_m = 1.5;
  options.light = light;
  options.threads = threads;
  return options;
}

// Everything shines by 1 and sends back half, and the sky around it shines by 2: so does all light.
void makeFurnace(Scene& scene) {
  for (Material& material : scene.materials) {
    material.base_color = glm::vec3(0.5f);
    material.emissive = glm::vec3(1.0f);
  }
  scene.light = {};
  scene.light.sky = {glm::vec3(2.0f), glm::vec3(2.0f), glm::vec3(2.0f)};
}

// All probes with their bare tents, as a bake hands it to its light.
LightGrid tentGrid(const PreparedScene& scene) {
  LightGrid grid;
  grid.tree = scene.treeInWorld();
  grid.probe_function.assign(grid.tree.probeCount(), kFreeSpace);
  return grid;
}

TEST(LightBake, FurnaceGivesEveryProbeTheSame) {
  for (const char* way : {"solved", "integrated", "point"}) {
    for (const bool cached : {true, false}) {
      BakeOptions options = roomOptions(way);
      options.light_cache = cached;
      options.light_error = kLeastLightError;
      PreparedScene scene("two_rooms:0", options);
      makeFurnace(scene.source.scene);
      LightGrid grid = tentGrid(scene);
      const LightStatistics statistics = bakeLight(scene, options, &grid);
      EXPECT_TRUE(statistics.is_lit);
      EXPECT_FALSE(statistics.is_gathered);
      EXPECT_NEAR(statistics.mean, 2.0, 0.02) << way;
      ASSERT_EQ(grid.light.size(), grid.tree.probeCount() * kShFloats);
      double sum = 0.0;
      for (size_t probe = 0; probe < grid.tree.probeCount(); ++probe) {
        const float* light = &grid.light[probe * kShFloats];
        const float up = shIrradiance(light, 0.0f, 1.0f, 0.0f)[1];
        // 64 rays a place: a few per cent of noise at single probes
        EXPECT_NEAR(up, 2.0f * kPi, 0.2f * 2.0f * kPi) << way << ", probe " << probe;
        sum += up;
      }
      EXPECT_NEAR(sum / static_cast<double>(grid.tree.probeCount()), 2.0 * kPi, 0.01 * 2.0 * kPi) << way;
    }
  }
}

TEST(LightBake, SaysWhatIsBlackNearlyBlackOrTooBrightForEngines) {
  BakeOptions options = roomOptions("integrated");
  options.light_rays = 8;
  PreparedScene scene("two_rooms:0", options);
  LightGrid grid = tentGrid(scene);
  // all light is 2 times the factor
  const auto warningOf = [&](float factor) {
    makeFurnace(scene.source.scene);
    for (Material& material : scene.source.scene.materials) material.emissive *= factor;
    scene.source.scene.light.sky = {glm::vec3(2.0f * factor), glm::vec3(2.0f * factor), glm::vec3(2.0f * factor)};
    const std::vector<std::string> warnings = lightWarnings(bakeLight(scene, options, &grid));
    return warnings.empty() ? std::string() : warnings.back();
  };
  EXPECT_EQ(warningOf(1.0f), "");
  EXPECT_EQ(warningOf(0.006f), "");
  EXPECT_NE(warningOf(0.004f).find("nearly black"), std::string::npos);
  EXPECT_NE(warningOf(0.0f).find("no light reaches"), std::string::npos);
  // the first coefficient is sqrt(4 pi) times radiance: 3.54 x 2 x 10^4 is over 32,768, a tenth of it is not
  EXPECT_NE(warningOf(1e4f).find("0.1 times this --intensity"), std::string::npos);
  EXPECT_EQ(warningOf(4e3f), "");
  EXPECT_TRUE(lightWarnings({}).empty()) << "of a grid that was not to have light";
  Lamp in_air, in_solid;
  in_air.position = glm::vec3(scene.air.places[0]);
  const Bounds bounds = sceneBounds(scene.source.scene);
  for (int x = 0; x < 1000; ++x) {
    const glm::vec3 place = bounds.min + (bounds.max - bounds.min) * glm::vec3(x / 1000.0f, 0.5f, 0.5f);
    if (!isInAir(scene.rays, glm::dvec3(place))) in_solid.position = place;
  }
  scene.source.scene.light.lamps = {in_air, in_solid};
  const LightStatistics buried = bakeLight(scene, options, &grid);
  EXPECT_EQ(buried.buried_lamps_m.size(), 1u);
  EXPECT_NE(lightWarnings(buried).at(0).find("1 lamp in solid"), std::string::npos) << lightWarnings(buried)[0];
}

// A room that the sky lights through a window, and a closed one beside it; of many such rooms three are named.
TEST(LightBake, NamesRoomsThatNoLightReaches) {
  BakeOptions options = roomOptions("integrated");
  options.spacing_m = 0.5;
  options.light_rays = 8;
  PreparedScene scene("kitchen:0", options);
  LightGrid grid = tentGrid(scene);
  LightStatistics statistics = bakeLight(scene, options, &grid);
  ASSERT_EQ(statistics.dark_rooms.size(), 1u);
  EXPECT_NE(lightWarnings(statistics).at(0).find("no light reaches a room of 16 m3 around"), std::string::npos)
      << lightWarnings(statistics)[0];
  statistics.dark_rooms.resize(5, {});
  EXPECT_EQ(lightWarnings(statistics).size(), 4u);
  EXPECT_EQ(lightWarnings(statistics)[3], "no light reaches 2 other rooms, smaller than these");
}

TEST(LoadLitScene, OpenGroundWithASmallLampIsLitByDayARoomIsNot) {
  const TemporaryFolder folder;
  folder.write("lamp.mtl", "newmtl lamp\nKe 1 1 1\nnewmtl grey\nKd 0.5 0.5 0.5\n");
  const std::string lamp = "mtllib lamp.mtl\nv 0 1 0\nv 0.1 1 0\nv 0 1.1 0\nusemtl lamp\nf 1 2 3\nusemtl grey\n";
  const std::string ground = "v -9 0 9\nv 9 0 9\nv 9 0 -9\nv -9 0 -9\nf 4 5 6 7\n";
  const std::string roof = "v -9 3 9\nv 9 3 9\nv 9 3 -9\nv -9 3 -9\nf 11 10 9 8\n";
  const SceneSource open = loadLitScene(folder.write("open.obj", lamp + ground), {});
  EXPECT_EQ(open.scene.light.sky.zenith, defaultSky().zenith);
  ASSERT_EQ(open.light_notes.size(), 1u);
  EXPECT_NE(open.light_notes[0].find("open"), std::string::npos);
  const SceneSource covered = loadLitScene(folder.write("covered.obj", lamp + ground + roof), {});
  EXPECT_FALSE(hasLightFromOutside(covered.scene));
  EXPECT_TRUE(covered.light_notes.empty());
  BakeOptions night;
  night.scene_light.sky = {"0"};
  EXPECT_FALSE(hasLightFromOutside(loadLitScene(folder / "open.obj", night).scene));
}

// Of a grid in which three probes of four have no weight, or none that is believed, so that many places have next to none: what is
// measured of methods is the light that a bake leaves in its file, to the last bit, and what they answer is its look-up.
TEST(LightBake, IsWhatMethodsOfTheSameWeightsAreSolvedFor) {
  const BakeOptions options = roomOptions("solved");
  const PreparedScene scene("two_rooms:0", options);
  LightGrid grid = tentGrid(scene);
  grid.representations = {Representation::tentMlp()};
  Theta theta(grid.representations[0].thetaCount());
  theta.back() = 0.5f * kResidue;  // of the tent, everywhere
  const uint32_t faint = grid.addFunction(0, theta.data());
  Random random(1);
  for (uint32_t& function : grid.probe_function) {
    const uint32_t drawn = random.below(4);
    function = drawn == 0 ? kFreeSpace : drawn == 1 ? kNoWeight : faint;
  }
  const WeightsAt weights_at = weightsOf(grid, scene.source.scene.origin_m);
  int unsure = 0;
  for (const glm::dvec3& place : scene.air.places) {
    ProbeWeights weights;
    weights_at(place, &weights);
    unsure += weights.count > 0 && std::accumulate(weights.weight, weights.weight + weights.count, 0.0f) < 0.1f;
  }
  EXPECT_GT(unsure, 100);

  LightGrid baked = grid;
  bakeLight(scene, options, &baked);
  const LightTransport transport(scene.source.scene, scene.rays);
  MethodSet methods({transport, scene.tree, scene.air}, methodSetOptions(options, {64, 64}, scene.air.places.size(), 1));
  methods.addGrid("grid", std::move(grid), 0.0, {LightWay::solved});
  const std::vector<LightSh>& measured = *methods.methods().back().probe_light;
  ASSERT_EQ(measured.size() * kShFloats, baked.light.size());
  for (size_t i = 0; i < baked.light.size(); ++i)
    EXPECT_EQ(measured[i / kShFloats][i % kShFloats / kShChannels][static_cast<int>(i % kShChannels)], baked.light[i]) << i;

  int lit_by_darkest = 0;
  for (const glm::dvec3& place : scene.air.places) {
    const glm::dvec3 world = scene.source.scene.origin_m + place;
    const float up[3] = {0, 1, 0};
    float rgb[3];
    const LightStatus status = lookUpIrradiance(baked, {world.x, world.y, world.z}, up, rgb);
    const LightAnswer answer = answerAt(methods.methods().back().light_at, {place, {0.0f, 1.0f, 0.0f}});
    for (int c = 0; c < 3; ++c) ASSERT_EQ(answer.irradiance[c], rgb[c]);
    ASSERT_EQ(answer.reach == Reach::fallback, status == LightStatus::faint);
    lit_by_darkest += status == LightStatus::faint && rgb[0] > 0.0f;
  }
  EXPECT_GT(lit_by_darkest, 10);
}

}  // namespace
}  // namespace nlg
