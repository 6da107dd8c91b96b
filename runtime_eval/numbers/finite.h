// Tests whether all numbers of an array are finite.
//
// A theta has to be asked itself. The values that it stands for can be finite even when one of its weights is infinite, because a
// sigmoid at the output maps infinity to 0 or 1.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

namespace nlg {

inline bool allFinite(std::span<const float> values) {
  return std::all_of(values.begin(), values.end(), [](float value) { return std::isfinite(value); });
}

}  // namespace nlg
