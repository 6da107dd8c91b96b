// Scenes of extreme size and place.

#include <fmt/format.h>

#include "scene/procedural.h"
#include "validate/stability/scene_measures.h"

namespace nlg {
namespace {

FaceScene scaled(FaceScene faces, double scale, const glm::dvec3& shift) {
  for (glm::dvec3& position : faces.positions()) position = scale * position + shift;
  return faces;
}

// Rounding a position to float moves it by 6e-8 of its size; only points whose link or ray passes an edge so closely may change.
constexpr double kGrazingShare = 1e-4;

StabilityResult measureScale(const StabilityInputs& inputs, double scale) {
  const ProbeFunctions room = probeFunctions(inputs, furnishedRoom().finish());
  const ProbeFunctions other =
      probeFunctions(inputs, scaled(furnishedRoom(), scale, glm::dvec3(0.0)).finish(), kRoomSpacing_m * scale);
  const FunctionDifference apart = difference(room, other);
  StabilityResult result;
  result.holds =
      apart.same_outcomes && other.broken == 0 && room.count(ProbeOutcome::function) > 0 &&
      static_cast<double>(apart.points_apart + apart.validity_apart) <= kGrazingShare * static_cast<double>(apart.points);
  result.measured = describe(other) + "; against the room of 4 m: " + describe(apart);
  addFigures(other, &result);
  addFigures(apart, &result);
  return result;
}

StabilityResult measureFarAway(const StabilityInputs& inputs) {
  FaceScene house;
  house.add(makeProceduralScene("house", 3));
  const ProbeFunctions here = probeFunctions(inputs, house.finish());
  StabilityResult result;
  result.holds = here.count(ProbeOutcome::function) > 0 && here.broken == 0;
  FunctionDifference worst;
  for (const glm::dvec3& shift : {glm::dvec3(100000.0, 0.0, 0.0), glm::dvec3(-100000.0, 3000.0, 70001.0)}) {
    const ProbeFunctions there = probeFunctions(inputs, scaled(house, 1.0, shift).finish());
    const FunctionDifference apart = difference(here, there);
    result.holds = result.holds && apart.same_bits();
    if (worst.points == 0 || apart.largest_bytes > worst.largest_bytes || !apart.same_outcomes) worst = apart;
  }
  result.measured = describe(here) + "; 100 km away: " + describe(worst);
  addFigures(here, &result);
  addFigures(worst, &result);
  return result;
}

}  // namespace

std::vector<StabilityCase> sceneSizeCases() {
  const auto brief = StabilityDepth::brief, full = StabilityDepth::full;
  const std::string scale_must_hold =
      "the functions are those of a room of 4 m but for one point in ten thousand, whose links graze an edge";
  return {
      {"scenes", "1 mm across", scale_must_hold, brief, false,
       [](const StabilityInputs& inputs) { return measureScale(inputs, 0.00025); }},
      {"scenes", "100 km across", scale_must_hold, full, false,
       [](const StabilityInputs& inputs) { return measureScale(inputs, 25000.0); }},
      {"scenes", "100 km from the origin", "the functions are bit for bit those at the origin", brief, false, measureFarAway},
  };
}

}  // namespace nlg
