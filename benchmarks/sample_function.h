// A weighting function that stands for many: the tent, cut by a wall and with a solid corner.
#pragma once

#include "runtime_eval/support/weighting_function.h"

namespace nlg {

inline WeightingFunction wallFunction() {
  WeightingFunction function = tentFunction();
  const PointSet& points = stratifiedSupportPoints();
  function.valid_count.assign(kStratumCount, 0);
  for (int i = 0; i < kSupportPointCount; ++i) {
    if (points.x[i] + 0.3f * points.y[i] > 0.37f && points.z[i] > -0.2f) function.phi[i] = 0.0f;
    if (points.x[i] > 0.37f && points.z[i] > 0.6f) function.mask[i] = 0.0f;
    function.valid_count[i / kStratumPointCount] += function.mask[i] > 0.0f;
  }
  return function;
}

}  // namespace nlg
