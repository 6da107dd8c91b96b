// Errors of a grid's blends against its target functions, from both sides: holes, where probes are missing, and leaks, from
// probes that must have no weight. Formulas: docs/theory/math.md §7.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include <nlohmann/json.hpp>

#include "bake/blend_targets.h"

namespace nlg {

// Over the points of a class whose target weights add up to something. All 0 where there are none.
struct BlendFigures {
  uint64_t points = 0;
  double holes = 0.0;            // share of points: next to no weight, though target weights are there
  double leaks = 0.0;            // share of points: probes without a target weight hold more than a fifth of the light
  double total_variation = 0.0;  // [0, 1], mean: between the probes' shares and those of the target weights

  bool operator==(const BlendFigures&) const = default;
};

using BlendErrors = std::array<BlendFigures, kBlendClassCount>;

// targets   of all probes
// grid      of the same scene, in the world's coordinates
BlendErrors blendErrors(const BlendTargets& targets, const LightGrid& grid);

// Keys: docs/reference/bake_json.md.
nlohmann::ordered_json toJson(const BlendErrors& errors);
// Two lines.
std::string toText(const BlendErrors& errors);

}  // namespace nlg
