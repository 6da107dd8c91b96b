#include "runtime_eval/fit/normal_equations.h"

#include "runtime_eval/fit/field_normal_equations.h"
#include "runtime_eval/fit/network_loss.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/fit/normal_equations.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include "runtime_eval/evaluator/tiny_network-inl.h"
#include "runtime_eval/fit/gram-inl.h"

#ifndef NLG_NORMAL_EQUATIONS_CONSTANTS
#define NLG_NORMAL_EQUATIONS_CONSTANTS
namespace nlg {
// D derivative rows, the residual, and zero rows up to a whole number of tiles
inline constexpr int kJacobianRowCount = (ThetaLayout::count + 1 + 3) / 4 * 4;
// rows a power of two apart would all fall into the same set of the first-level cache
inline constexpr int kJacobianStride = kStratumPointCount + 16;
}  // namespace nlg
#endif

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {

// Derivatives of the masked representation by theta for one vector of points, one row a parameter; the residual last.
HWY_INLINE void storeJacobianColumn(FloatTag d, const float* HWY_RESTRICT theta, Floats slope, const Floats* position,
                                    Floats factor, Floats mask, Floats phi, float* HWY_RESTRICT column) {
  using L = ThetaLayout;
  const auto store = [&](int row, Floats value) { hn::Store(value, d, column + row * kJacobianStride); };
  const Floats one = hn::Set(d, 1.0f), zero = hn::Zero(d);
  Hidden<1> hidden;
  Floats output;
  forwardNetwork<1>(d, theta, slope, &position[0], &position[1], &position[2], hidden, &output);
  const Floats scale = hn::Mul(factor, mask);
  store(ThetaLayout::count, hn::MulSub(scale, output, hn::Mul(mask, phi)));
  store(L::b3, scale);
  Floats second[kHiddenCount];
  for (int j = 0; j < kHiddenCount; ++j) {
    const Floats derivative = hn::IfThenElse(hn::Gt(hidden.second[j][0], zero), one, slope);
    second[j] = hn::Mul(hn::Mul(scale, hn::Set(d, theta[L::w3 + j])), derivative);
    store(L::w3 + j, hn::Mul(scale, hidden.second[j][0]));
    store(L::b2 + j, second[j]);
    for (int i = 0; i < kHiddenCount; ++i) store(L::w2 + kHiddenCount * j + i, hn::Mul(second[j], hidden.first[i][0]));
  }
  for (int i = 0; i < kHiddenCount; ++i) {
    Floats sum = zero;
    for (int j = 0; j < kHiddenCount; ++j) {
      sum = hn::MulAdd(hn::Set(d, theta[L::w2 + kHiddenCount * j + i]), second[j], sum);
    }
    const Floats first = hn::Mul(sum, hn::IfThenElse(hn::Gt(hidden.first[i][0], zero), one, slope));
    store(L::b1 + i, first);
    for (int a = 0; a < 3; ++a) store(L::w1 + 3 * i + a, hn::Mul(first, position[a]));
  }
}

// products   kJacobianRowCount², lower triangle of tiles: the products of all rows over one stratum are added in double
void jacobianProducts(int stratum, const Representation& representation, const WeightingFunction& function,
                      const float* HWY_RESTRICT theta, float* HWY_RESTRICT jacobian, double* HWY_RESTRICT products) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Floats slope = hn::Set(d, representation.slope), one = hn::Set(d, 1.0f);
  const PointSet& points = stratifiedSupportPoints();
  const int first = stratum * kStratumPointCount;
  for (int i = 0; i < kStratumPointCount; i += lanes) {
    const int at = first + i;
    const Floats position[3] = {hn::Load(d, &points.x[at]), hn::Load(d, &points.y[at]), hn::Load(d, &points.z[at])};
    const Floats factor = representation.tentFactor() ? hn::Load(d, &points.tent[at]) : one;
    storeJacobianColumn(d, theta, slope, position, factor, hn::Load(d, &function.mask[at]), hn::Load(d, &function.phi[at]),
                        jacobian + i);
  }
  addGram(jacobian, kJacobianRowCount, kJacobianStride, kStratumPointCount, products);
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(jacobianProducts);

NormalEquationsKernel::NormalEquationsKernel() : jacobian_(size_t{kJacobianRowCount} * kJacobianStride, 0.0f) {}

void NormalEquationsKernel::compute(const Representation& representation, const WeightingFunction& function, const float* theta,
                                    NormalEquations* equations, int hessian_points, int first_batch) {
  if (representation.isField()) {
    fieldNormalEquations(pointOrder(representation), function, theta, equations);
  } else {
    computeNetwork(representation, function, theta, hessian_points, first_batch, equations);
  }
}

void NormalEquationsKernel::computeNetwork(const Representation& representation, const WeightingFunction& function,
                                           const float* theta, int hessian_points, int first_batch, NormalEquations* equations) {
  constexpr int kCount = ThetaLayout::count, kResidual = kCount * kJacobianRowCount;
  double products[kJacobianRowCount * kJacobianRowCount] = {};
  int valid_count = 0, used_count = 0;
  uint32_t used = 0;
  for (const int count : function.valid_count) valid_count += count;
  for (int i = 0; i < kStratumCount && used_count < std::min(hessian_points, valid_count); ++i) {
    const int stratum = (first_batch + i) % kStratumCount;
    if (function.valid_count[stratum] == 0) continue;
    HWY_DYNAMIC_DISPATCH(jacobianProducts)(stratum, representation, function, theta, jacobian_.data(), products);
    used_count += function.valid_count[stratum];
    used |= 1u << stratum;
  }
  const double scale = used_count > 0 ? static_cast<double>(valid_count) / used_count : 1.0;
  equations->hessian.reset(kCount, kCount - 1);
  equations->gradient.assign(kCount, 0.0);
  for (int r = 0; r < kCount; ++r) {
    for (int c = 0; c <= r; ++c) equations->hessian.at(r, c) = scale * products[r * kJacobianRowCount + c];
    equations->gradient[r] = products[kResidual + r];
  }
  equations->square_sum = products[kResidual + kCount];
  // the strata that the products left out
  for (int stratum = 0; stratum < kStratumCount; ++stratum) {
    if ((used >> stratum & 1) != 0 || function.valid_count[stratum] == 0) continue;
    float gradient[kCount];
    const int first = stratum * kStratumPointCount;
    equations->square_sum += networkLossAndGradient(representation, stratifiedSupportPoints(), first, kStratumPointCount,
                                                    &function.phi[first], &function.mask[first], theta, gradient);
    for (int i = 0; i < kCount; ++i) equations->gradient[i] += 0.5 * gradient[i];
  }
}

}  // namespace nlg
#endif  // HWY_ONCE
