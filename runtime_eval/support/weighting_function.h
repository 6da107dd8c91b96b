// A weighting function as the fitting kernels read it: samples and mask as floats, in the order of a representation.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime_eval/simd/aligned.h"
#include "runtime_eval/support/point_order.h"
#include "runtime_eval/support/stored_function.h"

namespace nlg {

// The function at a place of what holds many as a data set does: `phi` N x P and `validity` N x P / 8, one behind another.
template <class Functions>
StoredFunction storedFunction(const Functions& functions, size_t index) {
  return {&functions.phi[index * kSupportPointCount], &functions.validity[index * kValidityByteCount]};
}

// Decodes one batch of a stored function, mirrored by `mirror` (bits as in SupportPattern; 0 leaves it as it is).
// phi, mask   as many as the batch has places; mask is 1 at valid points, 0 at others and at places without a point; phi is in
//             [0, 1]
// returns     how many points of the batch are valid
int decodeBatch(const PointOrder& order, int batch, const StoredFunction& stored, int mirror, float* phi, float* mask);

// A tent up to here is stored as 0: at the rim of the support a function is 0 wherever the probe sees.
inline constexpr float kRimTent = 0.5f / 255.0f;

struct WeightingFunction {
  AlignedFloats phi;   // by place of the order, [0, 1]
  AlignedFloats mask;  // by place, 0 where no point is valid, elsewhere 1 or what weighs it: residuals are multiplied by it
  std::vector<int> valid_count;  // by batch
  float dark_root = 1.0f;        // the mask at dark points
  int validCount() const;
};

// All batches of a stored function.
// dark_weight   at dark points, where phi is stored as 0 and the tent is not, a squared residual counts so many times: there the
//               mask is its root
WeightingFunction decodeFunction(const StoredFunction& stored, const PointOrder& order = stratumOrder(),
                                 double dark_weight = 1.0);

// The same into memory that has held a function of this order before, or none: the former allocates nothing.
void decodeFunction(const StoredFunction& stored, const PointOrder& order, double dark_weight, WeightingFunction* function);

// Any samples, by index into the support pattern: phi in [0, 1], valid false where a point is left out.
WeightingFunction functionFromSamples(const std::vector<float>& phi, const std::vector<bool>& valid, const PointOrder& order);

// The same function in another order.
WeightingFunction reordered(const WeightingFunction& function, const PointOrder& from, const PointOrder& to);

// The bare tent, valid everywhere: the function of a probe in free space.
WeightingFunction tentFunction(const PointOrder& order = stratumOrder());

}  // namespace nlg
