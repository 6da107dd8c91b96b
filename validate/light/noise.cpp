#include "validate/light/noise.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/light_grid/spherical_harmonics.h"
#include "runtime_eval/numbers/random.h"
#include "tool/error.h"
#include "validate/errors/statistics.h"

namespace nlg {
namespace {

constexpr uint64_t kRunStream = 0x72756e;

// Of one probe over runs: deviation over root mean square, and whether it has any light at all.
double noiseOf(const std::vector<std::vector<float>>& runs, size_t probe, bool* has_light) {
  double variance = 0.0, squares = 0.0;
  const auto count = static_cast<double>(runs.size());
  for (int k = 0; k < kShFloats; ++k) {
    double sum = 0.0, sum_squares = 0.0;
    for (const std::vector<float>& run : runs) {
      const double value = run[probe * kShFloats + k];
      sum += value;
      sum_squares += value * value;
    }
    variance += std::max(0.0, sum_squares - sum * sum / count) / (count - 1.0);
    squares += sum_squares / count;
  }
  *has_light = squares > 0.0;
  return *has_light ? std::sqrt(variance / squares) : 0.0;
}

}  // namespace

NoiseFigures measureNoise(const BakeScene& scene, const BakeOptions& options, LightGrid grid, int runs) {
  NLG_CHECK(runs, >=, 2);
  std::vector<std::vector<float>> light;
  std::vector<double> seconds, shares;
  for (int run = 0; run < runs; ++run) {
    BakeOptions of_run = options;
    of_run.threads = 1;
    of_run.seed = mixSeed(options.seed, kRunStream, static_cast<uint64_t>(run));
    const LightStatistics statistics = bakeLight(scene, of_run, &grid);
    const double total_s = statistics.cache_wall_s + statistics.measure_wall_s + statistics.solve_wall_s;
    seconds.push_back(total_s);
    shares.push_back(1.0 - statistics.solve_wall_s / total_s);
    light.push_back(grid.light);
  }
  std::vector<double> noise;
  for (size_t probe = 0; probe < grid.tree.probeCount(); ++probe) {
    bool has_light = false;
    const double of_probe = noiseOf(light, probe, &has_light);
    if (has_light && grid.probe_function[probe] != kNoWeight) noise.push_back(of_probe);
  }
  NoiseFigures figures;
  figures.probes = noise.size();
  if (noise.empty()) return figures;
  figures.noise_median = quantile(noise, 0.5);
  figures.noise_p95 = quantile(noise, 0.95);
  figures.probes_per_s = static_cast<double>(grid.tree.probeCount()) / quantile(seconds, 0.5);
  figures.measure_share = quantile(shares, 0.5);
  return figures;
}

}  // namespace nlg
