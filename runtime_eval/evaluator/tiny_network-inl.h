// Evaluates tiny networks at vectors of points, for any shape and any Highway target. Included once per target; see Highway's
// quick reference on "-inl.h".
#if defined(NLG_TINY_NETWORK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef NLG_TINY_NETWORK_INL_H_
#undef NLG_TINY_NETWORK_INL_H_
#else
#define NLG_TINY_NETWORK_INL_H_
#endif

#include <hwy/highway.h>

#include "nlg/representation.h"
#include "runtime_eval/evaluator/elementary-inl.h"

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Values of one hidden layer at kGroup vectors of points, kept in registers by the caller's loops. What depends on the activation
// is in here: another one may keep what its derivative needs.
template <int kWidth, int kGroup>
struct HiddenLayer {
  Floats value[kWidth][kGroup];

  HWY_INLINE void activate(int j, int g, Floats sum, Floats slope) { value[j][g] = hn::Max(sum, hn::Mul(slope, sum)); }
  HWY_INLINE Floats derivative(FloatTag d, int j, int g, Floats slope) const {
    return hn::IfThenElse(hn::Gt(value[j][g], hn::Zero(d)), hn::Set(d, 1.0f), slope);
  }
};

template <NetworkShape kShape, int kGroup>
struct Hidden {
  static_assert(kShape.first > 0 && kShape.first % 2 == 0 && kShape.second % 2 == 0);
  HiddenLayer<kShape.first, kGroup> first;
  HiddenLayer<kShape.last(), kGroup> second;  // not used when there is one hidden layer

  HWY_INLINE auto& last() {
    if constexpr (kShape.second > 0) {
      return second;
    } else {
      return first;
    }
  }
  HWY_INLINE const auto& last() const { return const_cast<Hidden*>(this)->last(); }
};

// Forward pass up to the output function: every weight is broadcast once for kGroup vectors.
template <NetworkShape kShape, int kGroup>
HWY_INLINE void forwardNetwork(FloatTag d, const float* HWY_RESTRICT theta, Floats slope, const Floats* x, const Floats* y,
                               const Floats* z, Hidden<kShape, kGroup>& hidden, Floats* output) {
#pragma GCC unroll 8
  for (int j = 0; j < kShape.first; ++j) {
    const float* row = theta + kShape.w1() + 3 * j;
    const Floats wx = hn::Set(d, row[0]), wy = hn::Set(d, row[1]), wz = hn::Set(d, row[2]);
    const Floats bias = hn::Set(d, theta[kShape.b1() + j]);
#pragma GCC unroll 4
    for (int g = 0; g < kGroup; ++g) {
      const Floats sum = hn::MulAdd(wz, z[g], hn::MulAdd(wy, y[g], hn::MulAdd(wx, x[g], bias)));
      hidden.first.activate(j, g, sum, slope);
    }
  }
  const Floats output_bias = hn::Set(d, theta[kShape.b3()]);
#pragma GCC unroll 4
  for (int g = 0; g < kGroup; ++g) output[g] = output_bias;
  constexpr int kLast = kShape.last();
#pragma GCC unroll 8
  for (int j = 0; j < kLast; ++j) {
    if constexpr (kShape.second > 0) {
      Floats sum[kGroup];
      const Floats bias = hn::Set(d, theta[kShape.b2() + j]);
#pragma GCC unroll 4
      for (int g = 0; g < kGroup; ++g) sum[g] = bias;
#pragma GCC unroll 8
      for (int i = 0; i < kShape.first; ++i) {
        const Floats weight = hn::Set(d, theta[kShape.w2() + kShape.first * j + i]);
#pragma GCC unroll 4
        for (int g = 0; g < kGroup; ++g) sum[g] = hn::MulAdd(weight, hidden.first.value[i][g], sum[g]);
      }
#pragma GCC unroll 4
      for (int g = 0; g < kGroup; ++g) hidden.second.activate(j, g, sum[g], slope);
    }
    const Floats weight = hn::Set(d, theta[kShape.w3() + j]);
#pragma GCC unroll 4
    for (int g = 0; g < kGroup; ++g) output[g] = hn::MulAdd(weight, hidden.last().value[j][g], output[g]);
  }
}

// The network's value and its derivative by the sum of the output layer.
struct OutputValue {
  Floats value, derivative;
};

template <OutputFunction kOutput>
HWY_INLINE OutputValue outputValue(FloatTag d, Floats sum) {
  if constexpr (kOutput == OutputFunction::linear) {
    return {sum, hn::Set(d, 1.0f)};
  } else {
    const Sigmoid s = sigmoid(d, sum);
    return {s.value, hn::Mul(s.value, s.complement)};
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();
#endif
