#include "validate/solved/walk.h"

#include <algorithm>
#include <cmath>

namespace nlg {
namespace {

std::vector<PointLinks::Link> stepsOf(const SolvedScene& scene) {
  const float pixel_m = scene.small.lattice.spacing_m / kSlicePixelsACell;
  std::vector<PointLinks::Link> steps;
  for (const PointLinks::Link& link : scene.links.links) {
    const bool on_slice = scene.points.use[link.a] == PointUse::slice && scene.points.use[link.b] == PointUse::slice;
    if (on_slice && link.distance_m < 1.1f * pixel_m) steps.push_back(link);
  }
  return steps;
}

// p99 and worst of a list; zeros without values.
std::pair<double, double> highest(std::vector<double> values) {
  if (values.empty()) return {0.0, 0.0};
  std::sort(values.begin(), values.end());
  return {values[static_cast<size_t>(0.99 * static_cast<double>(values.size() - 1))], values.back()};
}

double lightJump(const float* a, const float* b, int count) {
  double sum = 0.0;
  for (int s = 0; s < count; ++s) sum += (static_cast<double>(a[s]) - b[s]) * (static_cast<double>(a[s]) - b[s]);
  return std::sqrt(sum / count);
}

}  // namespace

WalkFigures walk(const SolvedScene& scene, const BlendWeights& weights) {
  const SamplePoints& points = scene.points;
  const Signals& signals = scene.light.test;
  const BlendWeights w = normalised(weights);
  const std::vector<float> probes = solveProbes(points, w, signals, pointsOf(points, {PointUse::fit}));
  std::vector<float> lit_a(signals.count), lit_b(signals.count);
  std::vector<double> weight_jumps, light_jumps;
  for (const PointLinks::Link& step : stepsOf(scene)) {
    weight_jumps.push_back(weightChange(points, w, step.a, step.b));
    blend(points.probe[step.a], w[step.a], probes, signals.count, lit_a.data());
    blend(points.probe[step.b], w[step.b], probes, signals.count, lit_b.data());
    light_jumps.push_back(lightJump(lit_a.data(), lit_b.data(), signals.count));
  }
  const auto [weight_p99, weight_worst] = highest(weight_jumps);
  const auto [light_p99, light_worst] = highest(light_jumps);
  return {weight_jumps.size(), weight_p99, weight_worst, light_p99, light_worst};
}

WalkFigures walkTrueLight(const SolvedScene& scene) {
  const Signals& signals = scene.light.test;
  std::vector<double> jumps;
  for (const PointLinks::Link& step : stepsOf(scene)) {
    jumps.push_back(lightJump(signals.row(step.a), signals.row(step.b), signals.count));
  }
  const auto [p99, worst] = highest(jumps);
  return {jumps.size(), 0.0, 0.0, p99, worst};
}

}  // namespace nlg
