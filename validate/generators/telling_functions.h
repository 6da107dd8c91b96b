// Chooses functions for pictures, and the slices that show them.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "datagen/dataset/function_set.h"
#include "validate/generators/policy_words.h"

namespace nlg {

// Square pictures of functions, for slices.json (docs/reference/formats.md): of those at the 5th, 50th and 95th percentile of the blend
// RMSE of what is stored, and of the worst; each of that plane through the probe of the three that tells most, function against
// bare tent and representation against function. Rows x columns, local coordinates from -1 to 1.
void appendSlices(const Representation& representation, const PolicyWords& words, const FunctionSet& set,
                  const Populations& populations, nlohmann::ordered_json* slices);

}  // namespace nlg
