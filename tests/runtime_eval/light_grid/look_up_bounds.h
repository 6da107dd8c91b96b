// What look-ups may lose to float, for tests.
#pragma once

#include <algorithm>
#include <cmath>

#include "nlg/light_grid.h"
#include "runtime_eval/evaluator/evaluate.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {

// What one value of a representation may lose to float, with evaluatePoint's operations counted:
inline double errorBound(const Representation& representation, const LocalPoint& point, const Theta& theta) {
  if (representation.isNetwork()) {
    // 3 + 3 and a slope, 1 + 5 and a slope, 1 + 9, the tent's 5 and its product: 30 roundings on the network of magnitudes
    return 30 * kFloatRounding * evaluateReference(representation, magnitudes(point), magnitudes(theta).data());
  }
  // A share is off by 3 roundings of a position up to r - 1 on each axis, along which A and B change by at most twice the largest
  // node; the weights and sums add 12 roundings. sigmoid has slope 1/4 and 5 roundings of its own. So it is of bricks of codes, whose
  // nodes are exact where codes are whole numbers.
  double largest = 0.0;
  for (const float value : theta) largest = std::max(largest, std::fabs(double{value}));
  if (representation.isCode()) {
    int8_t brick[kMaxBrickNodes];
    largest = kMostLogitSteps * double{packBrick(*representation.dictionary, theta.data(), brick)};
  }
  const double trilinear = (3 * 2 * 3 * (representation.resolution - 1) + 12) * kFloatRounding * largest;
  return 1.25 * trilinear + 5 * kFloatRounding;
}

inline Theta thetaOf(const LightGrid& grid, uint32_t function) {
  const float* first = grid.functionTheta(function);
  return {first, first + grid.representations[grid.function_representation[function]].thetaCount()};
}

}  // namespace nlg
