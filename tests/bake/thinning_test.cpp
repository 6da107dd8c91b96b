// Grids without what their light does not need: smaller, lit as before everywhere, and dark where it was dark.
#include "light/thinning.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bake/again/bake_provenance.h"
#include "bake/scene_bake.h"
#include "light/air.h"
#include "nlg/look_up.h"
#include "runtime_eval/grid_file/light_grid_file.h"
#include "runtime_eval/numbers/random.h"
#include "tests/bake/house_corner.h"
#include "tests/input_error.h"
#include "tests/runtime_eval/sample_generator.h"
#include "tool/error.h"

namespace nlg {
namespace {

BakeOptions corner() {
  BakeOptions options = houseCornerOptions();
  options.spacing_m = 1.0;
  options.light_rays = 16;
  takeThetaPrecision(&options);
  return options;
}

size_t bytesOf(const LightGrid& grid, const BakeOptions& options) {
  return lightGridBytes(grid, {options.policy.theta_precision, options.light_error}).total();
}

size_t withWeight(const LightGrid& grid) {
  return static_cast<size_t>(std::count_if(grid.probe_function.begin(), grid.probe_function.end(),
                                           [](uint32_t function) { return function != kNoWeight; }));
}

TEST(ThinnedGrid, IsSmallerAndLightsAsBefore) {
  const BakeOptions all = corner();
  BakeOptions some = all;
  some.thin_error = 0.05;
  const PreparedScene scene("house:3", all);
  const Bake whole = bakeOf(scene, all), thin = bakeOf(scene, some);
  const Thinned& thinned = thin.statistics.light.thinned;
  EXPECT_GT(thinned.functions, 0u);
  EXPECT_GT(thinned.probes, 0u);
  EXPECT_EQ(withWeight(thin.grid) + thinned.probes, withWeight(whole.grid));
  EXPECT_LT(thin.grid.functionCount(), whole.grid.functionCount());
  EXPECT_LT(bytesOf(thin.grid, some), 0.9 * static_cast<double>(bytesOf(whole.grid, all)));
  EXPECT_TRUE(checkLightGrid(thin.grid).ok());
  // of places that measured light, and of those that no choice has seen
  EXPECT_LT(thin.statistics.light.median_error, 1.1 * whole.statistics.light.median_error + 0.01);
  EXPECT_LT(thin.statistics.light.p95_error, 1.1 * whole.statistics.light.p95_error + 0.01);
  Random random(7);
  double squares = 0.0, of_light = 0.0;
  int places = 0;
  for (const glm::dvec3& near : scene.air.places) {
    const glm::dvec3 at = near + 0.1 * glm::dvec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    if (!isInAir(scene.rays, at)) continue;
    const glm::dvec3 world = at + scene.source.scene.origin_m;
    float before[kShFloats], now[kShFloats];
    const LightStatus status = lookUpLight(whole.grid, {world.x, world.y, world.z}, before);
    if (status != LightStatus::lit) continue;
    EXPECT_NE(lookUpLight(thin.grid, {world.x, world.y, world.z}, now), LightStatus::unlit);
    squares += (before[0] - now[0]) * (before[0] - now[0]);
    of_light += before[0] * before[0];
    ++places;
  }
  EXPECT_GT(places, 200);
  EXPECT_LT(std::sqrt(squares / of_light), 0.1);
}

// The budget is the whole file's, with all that it says of itself.
TEST(ThinnedGrid, KeepsABudgetOrSaysWhatItTakes) {
  BakeOptions options = corner();
  const PreparedScene scene("house:3", options);
  const GridMetadata metadata = {{"note", std::string(5000, 'x')}};
  const auto fileBytesOf = [&](const LightGrid& grid) {
    std::string bytes;
    EXPECT_TRUE(serializeLightGrid(grid, {options.policy.theta_precision, options.light_error}, metadata, &bytes).ok());
    return static_cast<double>(bytes.size());
  };
  const double all = fileBytesOf(bakeOf(scene, options).grid);
  options.max_bytes = std::floor(0.9 * all);
  const Bake fits = bakeOf(scene, options, metadata);
  EXPECT_GT(fits.statistics.light.thin_error, 0.0);
  EXPECT_LE(fileBytesOf(fits.grid), options.max_bytes);
  options.max_bytes = 5100.0;
  const std::string line = errorOfCall<UsageError>([&] { bakeOf(scene, options, metadata); });
  ASSERT_NE(line.find("spacing_m"), std::string::npos) << line;
  // the size that it names is one that is taken
  options.max_bytes = std::stod(line.substr(line.find("at least ") + 9));
  EXPECT_GT(options.max_bytes, 5100.0);
  EXPECT_LE(fileBytesOf(bakeOf(scene, options, metadata).grid), options.max_bytes) << line;
}

// Two rooms, a wall between them, a lamp in one: the functions that keep the other dark stay.
TEST(ThinnedGrid, KeepsTheDarkDark) {
  BakeOptions options = corner();
  options.extent_m.clear();
  options.thin_error = 0.1;
  const PreparedScene scene("daylight:8", options);
  BakeOptions all = options;
  all.thin_error = 0.0;
  const Bake whole = bakeOf(scene, all), thin = bakeOf(scene, options);
  ASSERT_GT(thin.statistics.light.thinned.functions, 0u);
  std::vector<glm::dvec3> beside;
  for (uint64_t seed = 90; seed < 96; ++seed) {
    const std::vector<glm::dvec3> of_seed = placesBesideSurfaces(scene.rays, scene.air.places, 1.0, seed);
    beside.insert(beside.end(), of_seed.begin(), of_seed.end());
  }
  const double dark = 0.02 * thin.statistics.light.mean;
  double before_sum = 0.0, now_sum = 0.0;
  int places = 0;
  for (const glm::dvec3& at : beside) {
    const glm::dvec3 world = at + scene.source.scene.origin_m;
    float before[kShFloats], now[kShFloats];
    if (lookUpLight(whole.grid, {world.x, world.y, world.z}, before) != LightStatus::lit || std::fabs(before[0]) > dark) continue;
    lookUpLight(thin.grid, {world.x, world.y, world.z}, now);
    before_sum += std::fabs(before[0]);
    now_sum += std::fabs(now[0]);
    ++places;
  }
  ASSERT_GT(places, 100);
  EXPECT_LT(now_sum / places, before_sum / places + 0.25 * dark);
}

TEST(ThinnedGrid, IsLitWhereAProbeWithoutWeightStands) {
  BakeOptions options = corner();
  options.thin_error = 0.1;
  const PreparedScene scene("house:3", options);
  const Bake thin = bakeOf(scene, options);
  const Bake whole = bakeOf(scene, corner());
  int left_out = 0;
  for (size_t p = 0; p < thin.grid.tree.probeCount(); ++p) {
    if (thin.grid.probe_function[p] != kNoWeight || whole.grid.probe_function[p] == kNoWeight) continue;
    ++left_out;
    float light[kShFloats];
    const LightStatus status = lookUpLight(thin.grid, thin.grid.tree.probePosition(p), light);
    EXPECT_TRUE(status == LightStatus::lit || status == LightStatus::faint || status == LightStatus::outside)
        << "probe " << p << ": " << lightStatusName(status);
  }
  EXPECT_GT(left_out, 0);
}

TEST(PlacesBesideSurfaces, StandInAirCloseToThem) {
  const PreparedScene scene("house:3", corner());
  const std::vector<glm::dvec3> beside = placesBesideSurfaces(scene.rays, scene.air.places, 1.0, 5);
  ASSERT_GT(beside.size(), scene.air.places.size() / 4);
  int in_air = 0;
  for (const glm::dvec3& at : beside) in_air += isInAir(scene.rays, at);
  EXPECT_GT(in_air, 0.97 * static_cast<double>(beside.size()));
}

}  // namespace
}  // namespace nlg
