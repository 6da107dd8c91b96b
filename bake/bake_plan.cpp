#include "bake/bake_plan.h"

#include <fmt/format.h>
#include <unistd.h>

#include "bake/light_bake.h"
#include "datagen/functions/function_collector.h"
#include "datagen/functions/function_rows.h"
#include "datagen/probes/shuffled_order.h"
#include "datagen/weighting/weighting_builder.h"
#include "runtime_eval/support/weighting_function.h"
#include "scene/model/oddities.h"
#include "tool/printable.h"
#include "tool/processor_time.h"

namespace nlg {
namespace {

// What the sample below does not see. Of twenty scenes: docs/lab/performance.md.
// Of a thread: for a probe, bounces between surfaces and the solve; and for a ray of a sample point.
constexpr double kLightProbeSeconds = 0.3e-3, kLightRaySeconds = 0.18e-6;
constexpr double kAirShare = 0.5;  // of sample points that cells could have: those in air
constexpr double kBaseBytes = 75e6, kProbeBytes = 6e3, kTriangleBytes = 400.0;

constexpr uint64_t kSampledProbes = 256;
constexpr double kMostSampleSeconds = 0.25;  // for functions, and as much again for their theta
constexpr size_t kThetaAtOnce = 4;

// Of a function that takes a theta, on average over as many as there is time for.
// with_theta   their rows
double thetaSeconds(const FunctionRows& rows, const std::vector<uint64_t>& with_theta, const BakeOptions& options,
                    const std::vector<Generator>& generators) {
  std::vector<const Generator*> pointers;
  for (const Generator& generator : generators) pointers.push_back(&generator);
  ThetaPolicy policy(pointers, options.policy, options.lastStage());
  std::vector<StoredFunction> functions;
  for (const uint64_t row : with_theta) functions.push_back(storedFunction(rows, row));
  double seconds = 0.0;
  size_t made_count = 0;
  while (made_count < functions.size() && seconds < kMostSampleSeconds) {
    const size_t count = std::min(kThetaAtOnce, functions.size() - made_count);
    std::vector<MadeTheta> made(count);
    const double start = threadSeconds();
    policy.bake(&functions[made_count], static_cast<int>(count), made.data());
    seconds += threadSeconds() - start;
    made_count += count;
  }
  return made_count == 0 ? 0.0 : seconds / static_cast<double>(made_count);
}

// Seconds of a thread that a probe's function and theta take, on average over a sample of probes.
double functionSeconds(const PlacedScene& scene, const BakeOptions& options, const std::vector<Generator>& generators) {
  const ProbeTree& tree = scene.full_tree;
  WeightingBuilder builder(scene.rays, options.diffusion, nullptr, options.points());
  ProbeLattice lattice(tree.frame());
  FunctionChecker checker;
  GeneratedFunction function;
  FunctionRows rows;
  rows.point_count = kSupportPointCount;
  double seconds = 0.0;
  uint64_t visited = 0;
  std::vector<uint64_t> with_theta;  // rows of them
  ShuffledOrder order(tree.probeCount(), options.seed);
  for (uint64_t probe; visited < kSampledProbes && seconds <= kMostSampleSeconds && order.next(&probe); ++visited) {
    const double start = threadSeconds();
    const auto [x, y, z] = tree.probePosition(probe);
    const float spacing_m = tree.probeSpacing(probe);
    // of probes in solid most are left out before anybody looks at them
    const ProbeOutcome outcome = builder.build({x, y, z}, spacing_m, &function, InSolid::left_out, &lattice);
    if (outcome == ProbeOutcome::in_solid || outcome == ProbeOutcome::free_space) continue;
    if (outcome == ProbeOutcome::function) {
      appendFunction(function, {x, y, z}, spacing_m, &rows);
      builder.sumBlend(function, &rows.blend_sum[rows.blend_sum.size() - kSupportPointCount]);
      const uint64_t row = rows.functionCount() - 1;
      const FunctionCheck tent = checker.checkBareTent(storedFunction(rows, row), options.policy.check());
      if (!takesBareTent(tent, options.policy)) with_theta.push_back(row);
    }
    seconds += threadSeconds() - start;
  }
  if (visited == 0) return 0.0;
  // theta have a sample of their own time, and count for all functions that take one
  seconds += static_cast<double>(with_theta.size()) * thetaSeconds(rows, with_theta, options, generators);
  return seconds / static_cast<double>(visited);
}

std::string sidesText(const glm::dvec3& sides) { return fmt::format("{:.4g} x {:.4g} x {:.4g} m", sides.x, sides.y, sides.z); }

}  // namespace

BakePlan planBake(const PlacedScene& scene, const BakeOptions& options, const std::vector<Generator>& generators) {
  const auto probes = static_cast<double>(scene.full_tree.probeCount());
  // a small sample of probes, timed on this machine, stands for all
  double seconds = generators.empty() ? 0.0 : functionSeconds(scene, options, generators);
  if (options.light != "none") {
    const auto places = static_cast<size_t>(kAirShare * probes * options.light_samples);
    seconds += kLightProbeSeconds + kLightRaySeconds * probeLightOptions(options, places).place.rays * options.light_samples;
  }
  const auto triangles = static_cast<double>(scene.source.scene.triangles.size());
  return {kBaseBytes + kProbeBytes * probes + kTriangleBytes * triangles, 0.2 + seconds * probes / threadsOf(options)};
}

std::string toText(const BakePlan& plan, const PlacedScene& scene, const BakeOptions& options) {
  const Bounds bounds = sceneBounds(scene.source.scene);
  const glm::dvec3 scene_m = glm::dvec3(bounds.max) - glm::dvec3(bounds.min), extent_m = scene.extent.high_m - scene.extent.low_m;
  std::string text = "plan: " + sidesText(scene_m);
  if (scene.source.unit_m > 0.0) text += fmt::format(" at {:g} m a unit", scene.source.unit_m);
  if (glm::length(extent_m - scene_m) > 0.5 * scene.spacing_m) text += ", probes in " + sidesText(extent_m);
  text += fmt::format(", {:.3g} m apart", scene.spacing_m);
  if (scene.boxes.inside == 1) text += " (in a box as nlg_density says)";
  if (scene.boxes.inside > 1) text += fmt::format(" (in {} boxes as nlg_density says)", scene.boxes.inside);
  text += fmt::format(": {} before those without air are left out; about {}", countText(scene.full_tree.probeCount(), "probe"),
                      bytesText(plan.memory_bytes));
  const double machine_bytes = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  if (plan.memory_bytes > machine_bytes) text += " (more than the " + bytesText(machine_bytes) + " of this machine)";
  text += fmt::format(", roughly {} on {}\n", durationText(plan.seconds),
                      countText(static_cast<uint64_t>(threadsOf(options)), "thread"));
  if (!scene.boxes.outside.empty())
    text += "nlg_density: outside what has probes, and changes nothing there: " + listed(scene.boxes.outside) + "\n";
  if (!scene.chosen) return text;
  const ChosenSpacing& chosen = *scene.chosen;
  return text + fmt::format("spacing: {:.3g} m was chosen (--spacing-m); {:.3g} m would take about {}, {:.3g} m about {}\n",
                            scene.spacing_m, chosen.finer_m, roughCountText(chosen.probes_of_finer, "probe"), chosen.coarser_m,
                            roughCountText(chosen.probes_of_coarser, "probe"));
}

}  // namespace nlg
