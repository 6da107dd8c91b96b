#include "validate/stability/scene_measures.h"

#include <fmt/format.h>

namespace nlg {

ProbePlacementOptions exactSpacing(double spacing_m) {
  ProbePlacementOptions options;
  options.spacing_min_m = options.spacing_max_m = spacing_m;
  return options;
}

ProbeFunctions probeFunctions(const StabilityInputs& inputs, const Scene& scene, double spacing_m) {
  return probeFunctions(scene, exactSpacing(spacing_m), inputs.depth == StabilityDepth::brief ? 24 : 200);
}

std::string describe(const ProbeFunctions& probes) {
  return fmt::format("{} probes of {}: {} functions, {} in free space, {} in solid, {} empty, {} unsound", probes.outcomes.size(),
                     probes.probe_count, probes.count(ProbeOutcome::function), probes.count(ProbeOutcome::free_space),
                     probes.count(ProbeOutcome::in_solid), probes.count(ProbeOutcome::empty), probes.broken);
}

void addFigures(const ProbeFunctions& probes, StabilityResult* result) {
  result->figures["probes"] = static_cast<double>(probes.outcomes.size());
  result->figures["functions"] = static_cast<double>(probes.count(ProbeOutcome::function));
  result->figures["unsound"] = static_cast<double>(probes.broken);
}

void addFigures(const FunctionDifference& apart, StabilityResult* result) {
  result->figures["largest_byte_difference"] = apart.largest_bytes;
  result->figures["points_compared"] = static_cast<double>(apart.points);
  result->figures["points_apart"] = static_cast<double>(apart.points_apart);
  result->figures["validity_apart"] = static_cast<double>(apart.validity_apart);
}

std::string describe(const FunctionDifference& apart) {
  if (!apart.same_outcomes) return "other outcomes";
  return fmt::format("largest byte difference of phi {}, {} of {} points more than one byte apart, {} in validity",
                     apart.largest_bytes, apart.points_apart, apart.points, apart.validity_apart);
}

StabilityResult measureSound(const StabilityInputs& inputs, const FaceScene& faces) {
  const Scene scene = faces.finish();
  const ProbeFunctions once = probeFunctions(inputs, scene);
  const ProbeFunctions again = probeFunctions(inputs, scene);
  StabilityResult result;
  result.holds = once.broken == 0 && !once.outcomes.empty() && difference(once, again).same_bits();
  result.measured = fmt::format("{}; {} votes about solid disputed", describe(once), once.disputed);
  addFigures(once, &result);
  result.figures["disputed"] = static_cast<double>(once.disputed);
  return result;
}

}  // namespace nlg
