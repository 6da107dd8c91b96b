// A weighting function for the fitting kernels: samples and mask as floats, in the order of a representation.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime_eval/support/loss_weights.h"
#include "runtime_eval/support/point_order.h"

namespace nlg {

// The function at a place of what holds many as a data set does: `phi` N x P and `validity` N x P / 8, one behind another.
template <class Functions>
StoredFunction storedFunction(const Functions& functions, size_t index) {
  StoredFunction function{&functions.phi[index * kSupportPointCount], &functions.validity[index * kValidityByteCount]};
  if constexpr (requires { functions.blend_sum; }) {
    if (!functions.blend_sum.empty()) function.blend_sum = &functions.blend_sum[index * kSupportPointCount];
  }
  return function;
}

// Decodes one batch of a stored function, mirrored by `mirror` (bits as in SupportPattern; 0 leaves it as it is).
// phi, mask   as many as the batch has places; mask is what residuals are multiplied by, LossWeights::root at valid points, 0 at others
//             and at places without a point; phi is in [0, 1]
// returns     how many points of the batch are valid
int decodeBatch(const PointOrder& order, int batch, const StoredFunction& stored, int mirror, const LossWeights& weights,
                float* phi, float* mask);

struct WeightingFunction {
  AlignedFloats phi;   // by place of the order, [0, 1]
  AlignedFloats mask;  // by place, 0 where no point is valid, elsewhere the root of its weight: residuals are multiplied by it
  std::vector<int> valid_count;  // by batch
  float dark_root = 1.0f;        // the mask at dark points: phi is 0 and the tent is not
  int validCount() const;
};

// All batches of a stored function.
WeightingFunction decodeFunction(const StoredFunction& stored, const PointOrder& order, const LossOptions& loss);

// The same into memory that has held a function of this order before, or none: the former allocates nothing.
void decodeFunction(const StoredFunction& stored, const PointOrder& order, const LossOptions& loss, WeightingFunction* function);

// Any samples, by index into the support pattern: phi in [0, 1], valid false where a point is left out.
WeightingFunction functionFromSamples(const std::vector<float>& phi, const std::vector<bool>& valid, const PointOrder& order);

// The same function in another order.
WeightingFunction reordered(const WeightingFunction& function, const PointOrder& from, const PointOrder& to);

// The bare tent, valid everywhere: the function of a probe in free space.
WeightingFunction tentFunction(const PointOrder& order = stratumOrder());

}  // namespace nlg
