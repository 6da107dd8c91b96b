#include "bake/bake_plan.h"

#include <fmt/format.h>
#include <unistd.h>

#include "scene/light_sets.h"
#include "scene/scene_size.h"
#include "tool/printable.h"

namespace nlg {
namespace {

// Of nine scenes from 210 to 110,000 probes, on two idle cores of a server: they took .4 to 1.7 times as long as this says, and .5 to
// 1.8 times the memory. Levels of which much is solid take least.
constexpr double kFunctionSeconds = 0.33e-3;  // of a thread, for a probe: air, function, theta
constexpr double kLightSeconds = 0.65e-6;     // for a ray of a place, bounces between surfaces included
constexpr double kBaseBytes = 75e6, kProbeBytes = 6e3, kTriangleBytes = 400.0;

constexpr double kMarginShare = 0.05;  // of a spacing: with so much air over a roof its cells find places in it (air_places.h)

std::string sidesText(const glm::dvec3& sides) { return fmt::format("{:.4g} x {:.4g} x {:.4g} m", sides.x, sides.y, sides.z); }

}  // namespace

ProbePlacementOptions placementOf(const SceneSource& source, const BakeOptions& options) {
  ProbePlacementOptions placement;
  placement.spacing_min_m = placement.spacing_max_m = options.spacing_m;
  placement.density_growth = options.density_growth;
  placement.align_lattice = options.align_lattice;
  placement.max_probes = options.max_probes;
  placement.extent = extentFromNumbers(options.extent_m);
  if (placement.extent || source.scene.extent) return placement;
  // as far as the lamps of all light sets
  for (const Scene* lit : litScenes(source)) {
    const std::optional<ExtentBox> reach = reachBeyondBounds(*lit, kMarginShare * options.spacing_m);
    if (!reach) continue;
    if (!placement.reach) placement.reach = reach;
    placement.reach->low_m = glm::min(placement.reach->low_m, reach->low_m);
    placement.reach->high_m = glm::max(placement.reach->high_m, reach->high_m);
  }
  return placement;
}

BakePlan planBake(const SceneSource& source, const BakeOptions& options, int thread_count) {
  const Scene& scene = source.scene;
  const ProbePlacementOptions placement = placementOf(source, options);
  BakePlan plan;
  plan.unit_m = source.unit_m;
  const Bounds bounds = sceneBounds(scene);
  plan.scene_m = glm::dvec3(bounds.max) - glm::dvec3(bounds.min);
  const ExtentBox box = probeExtent(scene, placement);
  plan.extent_m = box.high_m - box.low_m;
  plan.spacing_m = options.spacing_m;
  plan.probes = estimateProbes(scene, placement, options.seed);
  plan.memory_bytes = kBaseBytes + kProbeBytes * plan.probes + kTriangleBytes * static_cast<double>(scene.triangles.size());
  plan.machine_bytes = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  double seconds = kFunctionSeconds;
  if (options.light != "none")
    seconds += kLightSeconds * options.light_rays * options.light_places * static_cast<double>(litScenes(source).size());
  plan.seconds = 0.2 + seconds * plan.probes / thread_count;
  return plan;
}

std::string toText(const BakePlan& plan, int thread_count) {
  std::string text = "plan: " + sidesText(plan.scene_m);
  if (plan.unit_m > 0.0) text += fmt::format(" at {:g} m a unit", plan.unit_m);
  if (glm::length(plan.extent_m - plan.scene_m) > 0.5 * plan.spacing_m) text += ", probes in " + sidesText(plan.extent_m);
  const std::string machine =
      plan.memory_bytes > plan.machine_bytes ? " (more than the " + bytesText(plan.machine_bytes) + " of this machine)" : "";
  return text + fmt::format(", {:g} m apart: about {} before those without air are left out; about {}{}, roughly {} on {}\n",
                            plan.spacing_m, roughCountText(plan.probes, "probe"), bytesText(plan.memory_bytes), machine,
                            durationText(plan.seconds), countText(static_cast<uint64_t>(thread_count), "thread"));
}

}  // namespace nlg
