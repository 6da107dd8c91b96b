#include "bake/bake_plan.h"

#include <fmt/format.h>
#include <unistd.h>

#include "bake/light_bake.h"
#include "datagen/functions/function_collector.h"
#include "datagen/functions/function_rows.h"
#include "datagen/visibility/ray_scene.h"
#include "datagen/weighting/weighting_builder.h"
#include "runtime_eval/support/weighting_function.h"
#include "scene/lights/light_sets.h"
#include "scene/model/oddities.h"
#include "scene/scene_size.h"
#include "tool/printable.h"
#include "tool/processor_time.h"

namespace nlg {
namespace {

// What the sample below does not see. Of twenty scenes: docs/lab/performance.md.
// Of a thread: for a probe, bounces between surfaces and the solve; and for a ray of a sample point.
constexpr double kLightProbeSeconds = 0.3e-3, kLightRaySeconds = 0.18e-6;
constexpr double kAirShare = 0.5;  // of sample points that cells could have: those in air
constexpr double kBaseBytes = 75e6, kProbeBytes = 6e3, kTriangleBytes = 400.0;

constexpr double kMostSampleSeconds = 0.25;  // for functions, and as much again for their theta
constexpr size_t kThetaAtOnce = 4;

constexpr double kWidestChosenM = 10.0;

constexpr double kMarginShare = 0.05;  // of a spacing: with so much air over a roof its cells find places in it (air_places.h)

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
double functionSeconds(const PlacedSample& sample, const RayScene& rays, const BakeOptions& options,
                       const std::vector<Generator>& generators) {
  WeightingBuilder builder(rays, options.diffusion, nullptr, options.points());
  ProbeLattice lattice(sample.frame);
  FunctionChecker checker;
  GeneratedFunction function;
  FunctionRows rows;
  rows.point_count = kSupportPointCount;
  double seconds = 0.0;
  size_t visited = 0;
  std::vector<uint64_t> with_theta;  // rows of them
  for (const PlacedSample::Probe& probe : sample.probes) {
    if (seconds > kMostSampleSeconds) break;
    const double start = threadSeconds();
    ++visited;
    // of probes in solid most are left out before anybody looks at them
    const ProbeOutcome outcome = builder.build(probe.position_m, probe.spacing_m, &function, InSolid::left_out, &lattice);
    if (outcome == ProbeOutcome::in_solid || outcome == ProbeOutcome::free_space) continue;
    if (outcome == ProbeOutcome::function) {
      appendFunction(function, probe.position_m, probe.spacing_m, &rows);
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

ProbePlacementOptions placementOf(const SceneSource& source, const BakeOptions& options, std::optional<ChosenSpacing>* chosen) {
  ProbePlacementOptions placement;
  placement.density_growth = options.density_growth;
  placement.align_lattice = options.align_lattice;
  placement.max_probes = options.max_probes;
  placement.extent = extentFromNumbers(options.extent_m);
  placement.density = source.scene.density;
  const auto place = [&](double spacing_m) {
    placement.spacing_min_m = placement.spacing_max_m = spacing_m;
    placement.reach.reset();
    if (placement.extent || source.scene.extent) return;
    // as far as the lamps of all light sets
    for (const Scene* lit : litScenes(source)) {
      const std::optional<ExtentBox> reach = reachBeyondBounds(*lit, kMarginShare * spacing_m);
      if (!reach) continue;
      if (!placement.reach) placement.reach = reach;
      placement.reach->low_m = glm::min(placement.reach->low_m, reach->low_m);
      placement.reach->high_m = glm::max(placement.reach->high_m, reach->high_m);
    }
  };
  // to choose a spacing needs a placement: first with the one that is asked for, or the default
  place(options.spacing_m > 0.0 ? options.spacing_m : BakeOptions().spacing_m);
  if (options.spacing_m > 0.0) return placement;
  const ChosenSpacing choice = chooseSpacing(source.scene, placement);
  // rooms of a few metres are lost in it: more likely a unit is
  if (choice.spacing_m > kWidestChosenM && source.unit_m > 0.0 && options.reading.unit_m == 0.0) {
    throw UsageError(
        fmt::format("{}: probes would be {:.3g} m apart; give --unit 0.01 if it was made in centimetres, --unit 1 if in metres, "
                    "or --spacing-m",
                    source.id, choice.spacing_m));
  }
  place(choice.spacing_m);
  if (chosen != nullptr) *chosen = choice;
  return placement;
}

BakePlan planBake(const SceneSource& source, const BakeOptions& options, const std::vector<Generator>& generators,
                  int thread_count) {
  const Scene& scene = source.scene;
  BakePlan plan;
  const ProbePlacementOptions placement = placementOf(source, options, &plan.chosen);
  plan.unit_m = source.unit_m;
  const Bounds bounds = sceneBounds(scene);
  plan.scene_m = glm::dvec3(bounds.max) - glm::dvec3(bounds.min);
  const ExtentBox box = probeExtent(scene, placement);
  plan.extent_m = box.high_m - box.low_m;
  plan.spacing_m = placement.spacing_min_m;
  PlacedSample sample;
  plan.probes = estimateProbes(scene, placement, options.seed, &sample);
  plan.density_boxes = sample.boxes;
  plan.outside = sample.boxes_outside;
  plan.memory_bytes = kBaseBytes + kProbeBytes * plan.probes + kTriangleBytes * static_cast<double>(scene.triangles.size());
  plan.machine_bytes = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  // a small sample of probes, timed on this machine, stands for all
  double seconds = generators.empty() ? 0.0 : functionSeconds(sample, RayScene(scene), options, generators);
  if (options.light != "none") {
    const auto places = static_cast<size_t>(kAirShare * plan.probes * options.light_samples);
    seconds += (kLightProbeSeconds + kLightRaySeconds * probeLightOptions(options, places).place.rays * options.light_samples) *
               static_cast<double>(litScenes(source).size());
  }
  plan.seconds = 0.2 + seconds * plan.probes / thread_count;
  return plan;
}

std::string toText(const BakePlan& plan, int thread_count) {
  std::string text = "plan: " + sidesText(plan.scene_m);
  if (plan.unit_m > 0.0) text += fmt::format(" at {:g} m a unit", plan.unit_m);
  if (glm::length(plan.extent_m - plan.scene_m) > 0.5 * plan.spacing_m) text += ", probes in " + sidesText(plan.extent_m);
  const std::string machine =
      plan.memory_bytes > plan.machine_bytes ? " (more than the " + bytesText(plan.machine_bytes) + " of this machine)" : "";
  const std::string boxes = plan.density_boxes > 0
                                ? fmt::format(" (in {} as nlg_density says)",
                                              plan.density_boxes == 1 ? "a box" : fmt::format("{} boxes", plan.density_boxes))
                                : "";
  text += fmt::format(", {:.3g} m apart{}: about {} before those without air are left out; about {}{}, roughly {} on {}\n",
                      plan.spacing_m, boxes, roughCountText(plan.probes, "probe"), bytesText(plan.memory_bytes), machine,
                      durationText(plan.seconds), countText(static_cast<uint64_t>(thread_count), "thread"));
  if (!plan.outside.empty())
    text += "nlg_density: outside what has probes, and changes nothing there: " + listed(plan.outside) + "\n";
  if (!plan.chosen) return text;
  const ChosenSpacing& chosen = *plan.chosen;
  return text + fmt::format("spacing: {:.3g} m was chosen (--spacing-m); {:.3g} m would take about {}, {:.3g} m about {}\n",
                            plan.spacing_m, chosen.finer_m, roughCountText(chosen.probes_of_finer, "probe"), chosen.coarser_m,
                            roughCountText(chosen.probes_of_coarser, "probe"));
}

}  // namespace nlg
