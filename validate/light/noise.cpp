#include "validate/light/noise.h"

#include <algorithm>
#include <cmath>

#include "nlg/look_up.h"
#include "runtime_eval/numbers/random.h"
#include "tool/error.h"
#include "validate/generators/statistics.h"

namespace nlg {
namespace {

constexpr uint64_t kRunStream = 0x72756e;

// runs      of equal length, kShFloats floats a thing
// is_asked  by thing
Noise noiseOf(const std::vector<std::vector<float>>& runs, const std::vector<bool>& is_asked) {
  std::vector<double> noise;
  const auto count = static_cast<double>(runs.size());
  for (size_t thing = 0; thing < is_asked.size(); ++thing) {
    double variance = 0.0, squares = 0.0;
    for (size_t k = thing * kShFloats; k < (thing + 1) * kShFloats; ++k) {
      double sum = 0.0, sum_squares = 0.0;
      for (const std::vector<float>& run : runs) {
        const double value = run[k];
        sum += value;
        sum_squares += value * value;
      }
      variance += std::max(0.0, sum_squares - sum * sum / count) / (count - 1.0);
      squares += sum_squares / count;
    }
    if (is_asked[thing] && squares > 0.0) noise.push_back(std::sqrt(variance / squares));
  }
  if (noise.empty()) return {};
  return {noise.size(), quantile(noise, 0.5), quantile(noise, 0.95)};
}

}  // namespace

NoiseFigures measureNoise(const PreparedScene& scene, const BakeOptions& options, LightGrid grid, int runs) {
  NLG_CHECK(runs, >=, 2);
  // the same positions for every run, in world coordinates as look-ups take them
  std::vector<PositionM> places;
  for (const glm::dvec3& place : scene.air.places) {
    const glm::dvec3 world = place + scene.source.scene.origin_m;
    places.push_back({world.x, world.y, world.z});
  }
  std::vector<std::vector<float>> light, answers;
  std::vector<double> seconds, shares;
  LookUpScratch scratch;
  // runs differ in their seed alone; one thread, to time a core
  for (int run = 0; run < runs; ++run) {
    BakeOptions of_run = options;
    of_run.threads = 1;
    of_run.seed = mixSeed(options.seed, kRunStream, static_cast<uint64_t>(run));
    of_run.light_error = kLeastLightError;  // what rays leave, not what files do
    const LightStatistics statistics = bakeLight(scene, of_run, &grid);
    const double total_s = statistics.cache_wall_s + statistics.measure_wall_s + statistics.solve_wall_s;
    seconds.push_back(total_s);
    shares.push_back(1.0 - statistics.solve_wall_s / total_s);
    light.push_back(grid.light);
    std::vector<LightStatus> status(places.size());
    std::vector<float>& of_places = answers.emplace_back(places.size() * kShFloats);
    lookUpLights(grid, places.data(), places.size(), of_places.data(), status.data(), &scratch);
  }
  // a probe without function is never read
  std::vector<bool> has_function;
  for (const uint32_t function : grid.probe_function) has_function.push_back(function != kNoWeight);
  NoiseFigures figures;
  figures.probes = noiseOf(light, has_function);
  figures.answers = noiseOf(answers, std::vector<bool>(places.size(), true));
  figures.probes_per_s = static_cast<double>(grid.tree.probeCount()) / quantile(seconds, 0.5);
  figures.measure_share = quantile(shares, 0.5);
  return figures;
}

}  // namespace nlg
