// The weights of the loss: how much the squared residual counts at each support point. Every fit, training, check and
// comparison uses them (docs/theory/math.md §5).
//
// Light at a point is the mean of the probes' light, weighed by their functions: sum(phi_p E_p) / S, S = sum(phi_q) over the probes of the
// cell. To first order a residual r of one function shifts the light there by r (E_p - L) / S. So a lit point weighs 1 / S²: where this probe
// alone sees the point, a residual as large as phi is a hole; where eight probes see it nobody notices. S is taken as `blend_floor` at least:
// below, the crevices of a support would outweigh its open places. A dark point, where the probe must not count at all, weighs
// `dark_weight`, whatever S is: there a residual is a leak.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "nlg/support.h"

namespace nlg {

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

}  // namespace nlg
