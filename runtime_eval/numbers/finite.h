// Whether numbers are numbers. Of a theta the values of its representation do not tell: a sigmoid makes something finite of an
// infinite weight.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

namespace nlg {

inline bool allFinite(std::span<const float> values) {
  return std::all_of(values.begin(), values.end(), [](float value) { return std::isfinite(value); });
}

}  // namespace nlg
