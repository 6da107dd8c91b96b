// A weighting function for the fitting kernels: samples and mask as floats, in the order of a representation.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "nlg/support.h"
#include "runtime_eval/support/point_order.h"

namespace nlg {

// The weights of the loss: how much the squared residual counts at each support point. Every fit, training, check and
// comparison uses them (docs/theory/math.md §4).
//
// Light at a point is the mean of the probes' light, weighed by their functions: sum(phi_p E_p) / S, S = sum(phi_q) over the probes of the
// cell. To first order a residual r of one function shifts the light there by r (E_p - L) / S. So a lit point weighs 1 / S²: where this probe
// alone sees the point, a residual as large as phi is a hole; where eight probes see it nobody notices. S is taken as `blend_floor` at least:
// below, the crevices of a support would outweigh its open places. A dark point, where the probe must not count at all, weighs
// `dark_weight`, whatever S is: there a residual is a leak.

// A tent up to here is stored as 0: at the rim of the support a function is 0 wherever the probe sees.
inline constexpr float kRimTent = 0.5f / 255.0f;

// Residuals and values are compared as they are: what counts where nobody asks for the loss, and in plain RMSEs.
inline constexpr LossOptions kUnweighed{1.0, 1.0};

class LossWeights {
 public:
  explicit LossWeights(const LossOptions& options) : dark_root_(static_cast<float>(std::sqrt(options.dark_weight))) {
    const auto floor = static_cast<float>(options.blend_floor);
    for (size_t sum = 0; sum < lit_root_.size(); ++sum) lit_root_[sum] = 1.0f / std::max(floor, static_cast<float>(sum) / 255.0f);
  }

  // What residuals at a valid point are multiplied by: the root of its weight.
  // phi    as it is stored
  // tent   of the point
  // sum    StoredFunction::blend_sum of the point; 255 without
  float root(uint8_t phi, float tent, uint8_t sum) const {
    if (phi == 0) return tent > kRimTent ? dark_root_ : 1.0f;
    return lit_root_[sum];
  }
  float darkRoot() const { return dark_root_; }

 private:
  float dark_root_;
  std::array<float, 256> lit_root_{};
};

// The function at a place of what holds many as a data set does: `phi` N x P and `validity` N x P / 8, one behind another.
template <class Functions>
StoredFunction storedFunction(const Functions& functions, size_t index) {
  StoredFunction function{&functions.phi[index * kSupportPointCount], &functions.validity[index * kValidityByteCount]};
  if constexpr (requires { functions.blend_sum; }) {
    if (!functions.blend_sum.empty()) function.blend_sum = &functions.blend_sum[index * kSupportPointCount];
  }
  if constexpr (requires { functions.seen; }) {
    if (!functions.seen.empty()) function.seen = &functions.seen[index * kValidityByteCount];
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
