// Light of a scene of which it is known what every probe must hold.
#include "bake/light_bake.h"

#include <gtest/gtest.h>

#include "tool/error.h"
#include "validate/light/noise.h"

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
LightGrid tentGrid(const BakeScene& scene) {
  LightGrid grid;
  grid.tree = scene.tree;
  const glm::dvec3& origin_m = scene.source.scene.origin_m;
  grid.tree.moveBy({origin_m.x, origin_m.y, origin_m.z});
  grid.probe_function.assign(grid.tree.probeCount(), kFreeSpace);
  return grid;
}

TEST(LightBake, FurnaceGivesEveryProbeTheSame) {
  for (const char* way : {"solved", "integrated", "point"}) {
    for (const bool cached : {true, false}) {
      BakeOptions options = roomOptions(way);
      options.light_cache = cached;
      BakeScene scene("two_rooms:0", options);
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

TEST(LightBake, NoneLeavesTheGridWithoutLight) {
  const BakeScene scene("two_rooms:0", roomOptions("none"));
  LightGrid grid = tentGrid(scene);
  grid.light.assign(7, 1.0f);
  EXPECT_FALSE(bakeLight(scene, roomOptions("none"), &grid).is_lit);
  EXPECT_TRUE(grid.light.empty());
  EXPECT_THROW(bakeLight(scene, roomOptions("bright"), &grid), UsageError);
}

TEST(LightBake, SameBitsForAnyThreads) {
  const BakeScene scene("two_rooms:0", roomOptions("solved"));
  LightGrid one = tentGrid(scene), three = one;
  bakeLight(scene, roomOptions("solved", 1), &one);
  bakeLight(scene, roomOptions("solved", 3), &three);
  EXPECT_EQ(one.light, three.light);
}

TEST(LightNoise, FallsWithRays) {
  BakeOptions few = roomOptions("solved"), many = few;
  many.light_rays = 16 * few.light_rays;
  const BakeScene scene("two_rooms:0", few);
  const NoiseFigures coarse = measureNoise(scene, few, tentGrid(scene), 4);
  const NoiseFigures fine = measureNoise(scene, many, tentGrid(scene), 4);
  EXPECT_GT(coarse.probes, 0u);
  // a sixteenth of the variance, but for what a lattice gains beyond that
  EXPECT_LT(fine.noise_median, 0.5 * coarse.noise_median);
  EXPECT_GT(coarse.noise_median, 0.0);
}

}  // namespace
}  // namespace nlg
