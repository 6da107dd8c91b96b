// The tiny network on vectors of points, for any Highway target. Included once a target; see Highway's quick reference on
// "-inl.h".
#if defined(NLG_TINY_NETWORK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef NLG_TINY_NETWORK_INL_H_
#undef NLG_TINY_NETWORK_INL_H_
#else
#define NLG_TINY_NETWORK_INL_H_
#endif

#include <hwy/highway.h>

#include "runtime_eval/evaluator/representation.h"

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::CappedTag<float, 16>;
using Floats = hn::Vec<FloatTag>;

// Hidden values of kGroup vectors of points: kept in registers by the caller's loops.
template <int kGroup>
struct Hidden {
  Floats first[kHiddenCount][kGroup];
  Floats second[kHiddenCount][kGroup];
};

HWY_INLINE Floats leaky(Floats value, Floats slope) { return hn::Max(value, hn::Mul(slope, value)); }

// Forward pass: every weight is broadcast once for kGroup vectors.
template <int kGroup>
HWY_INLINE void forwardNetwork(FloatTag d, const float* HWY_RESTRICT theta, Floats slope, const Floats* x, const Floats* y,
                               const Floats* z, Hidden<kGroup>& hidden, Floats* output) {
  using L = ThetaLayout;
#pragma GCC unroll 8
  for (int j = 0; j < kHiddenCount; ++j) {
    const Floats wx = hn::Set(d, theta[L::w1 + 3 * j]), wy = hn::Set(d, theta[L::w1 + 3 * j + 1]);
    const Floats wz = hn::Set(d, theta[L::w1 + 3 * j + 2]), bias = hn::Set(d, theta[L::b1 + j]);
#pragma GCC unroll 4
    for (int g = 0; g < kGroup; ++g) {
      const Floats sum = hn::MulAdd(wz, z[g], hn::MulAdd(wy, y[g], hn::MulAdd(wx, x[g], bias)));
      hidden.first[j][g] = leaky(sum, slope);
    }
  }
  const Floats output_bias = hn::Set(d, theta[L::b3]);
#pragma GCC unroll 4
  for (int g = 0; g < kGroup; ++g) output[g] = output_bias;
#pragma GCC unroll 8
  for (int j = 0; j < kHiddenCount; ++j) {
    Floats sum[kGroup];
    const Floats bias = hn::Set(d, theta[L::b2 + j]);
#pragma GCC unroll 4
    for (int g = 0; g < kGroup; ++g) sum[g] = bias;
#pragma GCC unroll 8
    for (int i = 0; i < kHiddenCount; ++i) {
      const Floats weight = hn::Set(d, theta[L::w2 + kHiddenCount * j + i]);
#pragma GCC unroll 4
      for (int g = 0; g < kGroup; ++g) sum[g] = hn::MulAdd(weight, hidden.first[i][g], sum[g]);
    }
    const Floats weight = hn::Set(d, theta[L::w3 + j]);
#pragma GCC unroll 4
    for (int g = 0; g < kGroup; ++g) {
      hidden.second[j][g] = leaky(sum[g], slope);
      output[g] = hn::MulAdd(weight, hidden.second[j][g], output[g]);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();
#endif
