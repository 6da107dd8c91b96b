// A weighting function that stands for many: the tent, cut by a wall and with a solid corner.
#pragma once

#include <cmath>
#include <vector>

#include "runtime_eval/numbers/random.h"
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

// Stored functions of probes beside walls: the tent on this side of a random plane, nothing behind it, some of that solid.
// Appends count x P and count x P / 8 bytes.
inline void appendStoredWalls(int count, std::vector<uint8_t>* phi, std::vector<uint8_t>* validity) {
  for (int n = 0; n < count; ++n) {
    Random random(mixSeed(7, 0, static_cast<uint64_t>(n)));
    double normal[3], length = 0.0;
    for (double& part : normal) part = random.normal(), length += part * part;
    const double offset = random.uniform(0.1, 0.9), thickness = random.uniform(0.05, 0.2);
    std::vector<uint8_t> bits(kValidityByteCount, 0);
    for (int p = 0; p < kSupportPointCount; ++p) {
      const LocalPoint& point = supportPattern().points[p];
      double distance = -offset;
      for (int axis = 0; axis < 3; ++axis) distance += normal[axis] / std::sqrt(length) * point[axis];
      phi->push_back(distance < 0 ? static_cast<uint8_t>(std::lround(255.0f * tent(point))) : 0);
      if (distance < 0 || distance > thickness) bits[p / 8] |= static_cast<uint8_t>(1 << (p % 8));
    }
    validity->insert(validity->end(), bits.begin(), bits.end());
  }
}

}  // namespace nlg
