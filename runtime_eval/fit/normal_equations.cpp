#include "runtime_eval/fit/normal_equations.h"

#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/fit/loss/loss_kernel.h"

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
constexpr int jacobianRowCount(int theta_count) { return (theta_count + 1 + 3) / 4 * 4; }
inline constexpr int kMaxJacobianRowCount = jacobianRowCount(kMaxNetworkThetaCount);
// rows a power of two apart would all fall into the same set of the first-level cache
inline constexpr int kJacobianStride = kStratumPointCount + 16;
}  // namespace nlg
#endif

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {

// What the derivatives of one vector of points are made of.
struct JacobianInputs {
  Floats position[3];
  Floats factor, mask, phi;
};

// Derivatives of the masked representation by theta for one vector of points, one row a parameter; the residual last.
template <NetworkShape kShape>
HWY_INLINE void storeJacobianColumn(FloatTag d, const float* HWY_RESTRICT theta, Floats slope, const JacobianInputs& in,
                                    float* HWY_RESTRICT column) {
  const auto store = [&](int row, Floats value) { hn::Store(value, d, column + row * kJacobianStride); };
  Hidden<kShape, 1> hidden;
  Floats output;
  forwardNetwork<kShape, 1>(d, theta, slope, &in.position[0], &in.position[1], &in.position[2], hidden, &output);
  // the residual, and the derivative by b3: all other derivatives are this one times the chain rule's factors
  const OutputValue of = outputValue<kShape.output>(d, output);
  Floats scale = hn::Mul(in.factor, in.mask);
  store(kShape.thetaCount(), hn::MulSub(scale, of.value, hn::Mul(in.mask, in.phi)));
  if constexpr (kShape.output != OutputFunction::linear) scale = hn::Mul(scale, of.derivative);
  store(kShape.b3(), scale);
  // d representation / d sum of every unit of the last hidden layer, then of the first
  Floats last[kShape.last()], first[kShape.first];
  for (int j = 0; j < kShape.last(); ++j) {
    last[j] = hn::Mul(hn::Mul(scale, hn::Set(d, theta[kShape.w3() + j])), hidden.last().derivative(d, j, 0, slope));
    store(kShape.w3() + j, hn::Mul(scale, hidden.last().value[j][0]));
  }
  // back through W2 to the first layer, which in networks of one hidden layer is the last
  for (int i = 0; i < kShape.first; ++i) {
    if constexpr (kShape.second == 0) {
      first[i] = last[i];
      continue;
    }
    Floats sum = hn::Zero(d);
    for (int j = 0; j < kShape.second; ++j) {
      const int row = kShape.w2() + kShape.first * j + i;
      sum = hn::MulAdd(hn::Set(d, theta[row]), last[j], sum);
      store(row, hn::Mul(last[j], hidden.first.value[i][0]));
    }
    first[i] = hn::Mul(sum, hidden.first.derivative(d, i, 0, slope));
  }
  for (int j = 0; j < kShape.second; ++j) store(kShape.b2() + j, last[j]);
  for (int i = 0; i < kShape.first; ++i) {
    store(kShape.b1() + i, first[i]);
    for (int a = 0; a < 3; ++a) store(kShape.w1() + 3 * i + a, hn::Mul(first[i], in.position[a]));
  }
}

template <NetworkShape kShape>
void shapeJacobianProducts(int stratum, const Representation& representation, const WeightingFunction& function,
                           const float* HWY_RESTRICT theta, float* HWY_RESTRICT jacobian, double* HWY_RESTRICT products) {
  constexpr int kRowCount = jacobianRowCount(kShape.thetaCount());
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Floats slope = hn::Set(d, representation.slope), one = hn::Set(d, 1.0f);
  const bool tent_factor = representation.tentFactor();
  const PointSet& points = stratifiedSupportPoints();
  const int first = stratum * kStratumPointCount;
  for (int row = kShape.thetaCount() + 1; row < kRowCount; ++row)
    std::fill_n(jacobian + row * kJacobianStride, kStratumPointCount, 0.0f);
  for (int i = 0; i < kStratumPointCount; i += lanes) {
    const int at = first + i;
    const JacobianInputs in = {{hn::Load(d, &points.x[at]), hn::Load(d, &points.y[at]), hn::Load(d, &points.z[at])},
                               tent_factor ? hn::Load(d, &points.tent[at]) : one,
                               hn::Load(d, &function.mask[at]),
                               hn::Load(d, &function.phi[at])};
    storeJacobianColumn<kShape>(d, theta, slope, in, jacobian + i);
  }
  addGram(jacobian, kRowCount, kJacobianStride, kStratumPointCount, products);
}

// jacobian   jacobianRowCount(D) rows of kJacobianStride floats: workspace
// products   jacobianRowCount(D)², lower triangle of tiles: the products of all rows over one stratum are added in double
void jacobianProducts(int stratum, const Representation& representation, const WeightingFunction& function,
                      const float* HWY_RESTRICT theta, float* HWY_RESTRICT jacobian, double* HWY_RESTRICT products) {
  withNetworkShape(representation, [&]<NetworkShape kShape>() {
    shapeJacobianProducts<kShape>(stratum, representation, function, theta, jacobian, products);
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(jacobianProducts);

NormalEquationsKernel::NormalEquationsKernel() : jacobian_(size_t{kMaxJacobianRowCount} * kJacobianStride, 0.0f) {}

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
  const int theta_count = representation.thetaCount(), row_count = jacobianRowCount(theta_count);
  double products[kMaxJacobianRowCount * kMaxJacobianRowCount];
  std::fill_n(products, row_count * row_count, 0.0);
  int valid_count = 0, used_count = 0;
  uint32_t used = 0;
  // H only shapes the step and its products cost most: strata with enough valid points stand for all
  for (const int count : function.valid_count) valid_count += count;
  for (int i = 0; i < kStratumCount && used_count < std::min(hessian_points, valid_count); ++i) {
    const int stratum = (first_batch + i) % kStratumCount;
    if (function.valid_count[stratum] == 0) continue;
    HWY_DYNAMIC_DISPATCH(jacobianProducts)(stratum, representation, function, theta, jacobian_.data(), products);
    used_count += function.valid_count[stratum];
    used |= 1u << stratum;
  }
  // scaled to all valid points, so that H matches the gradient, which is over all
  const double scale = used_count > 0 ? static_cast<double>(valid_count) / used_count : 1.0;
  const double* residual_products = products + theta_count * row_count;
  equations->hessian.reset(theta_count, theta_count - 1);
  equations->gradient.assign(theta_count, 0.0);
  for (int r = 0; r < theta_count; ++r) {
    for (int c = 0; c <= r; ++c) equations->hessian.at(r, c) = scale * products[r * row_count + c];
    equations->gradient[r] = residual_products[r];
  }
  equations->square_sum = residual_products[theta_count];
  // the strata that the products left out
  for (int stratum = 0; stratum < kStratumCount; ++stratum) {
    if ((used >> stratum & 1) != 0 || function.valid_count[stratum] == 0) continue;
    float gradient[kMaxNetworkThetaCount];
    const int first = stratum * kStratumPointCount;
    equations->square_sum += networkLossAndGradient(representation, stratifiedSupportPoints(), first, kStratumPointCount,
                                                    &function.phi[first], &function.mask[first], theta, gradient);
    // J^T r is half of the gradient
    for (int i = 0; i < theta_count; ++i) equations->gradient[i] += 0.5 * gradient[i];
  }
}

}  // namespace nlg
#endif  // HWY_ONCE
