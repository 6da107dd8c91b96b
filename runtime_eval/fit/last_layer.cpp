#include "runtime_eval/fit/last_layer.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/fit/symmetric_band.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/fit/last_layer.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include "runtime_eval/evaluator/tiny_network-inl.h"
#include "runtime_eval/fit/gram-inl.h"

#ifndef NLG_LAST_LAYER_CONSTANTS
#define NLG_LAST_LAYER_CONSTANTS
namespace nlg {
// 8 hidden values and the constant 1, then phi, each masked and the former times the tent; zero rows up to whole tiles
inline constexpr int kFeatureCount = kHiddenCount + 1, kFeatureRowCount = 12;
}  // namespace nlg
#endif

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {

// products   kFeatureRowCount²: products of all rows are added, lower triangle of tiles, in float over 256 points, then in double
void featureProducts(const Representation& representation, const WeightingFunction& function, const float* HWY_RESTRICT theta,
                     double* HWY_RESTRICT products) {
  constexpr int kBlock = 256;
  alignas(64) float rows[kFeatureRowCount * kBlock] = {};
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Floats slope = hn::Set(d, representation.slope);
  const PointSet& points = stratifiedSupportPoints();
  for (int begin = 0; begin < kSupportPointCount; begin += kBlock) {
    for (int i = 0; i < kBlock; i += lanes) {
      const int at = begin + i;
      const Floats x = hn::Load(d, &points.x[at]), y = hn::Load(d, &points.y[at]), z = hn::Load(d, &points.z[at]);
      const Floats mask = hn::Load(d, &function.mask[at]);
      const Floats scale = representation.tentFactor() ? hn::Mul(mask, hn::Load(d, &points.tent[at])) : mask;
      Hidden<1> hidden;
      Floats output;
      forwardNetwork<1>(d, theta, slope, &x, &y, &z, hidden, &output);
      for (int j = 0; j < kHiddenCount; ++j) hn::Store(hn::Mul(scale, hidden.second[j][0]), d, rows + j * kBlock + i);
      hn::Store(scale, d, rows + kHiddenCount * kBlock + i);
      hn::Store(hn::Mul(mask, hn::Load(d, &function.phi[at])), d, rows + kFeatureCount * kBlock + i);
    }
    addGram(rows, kFeatureRowCount, kBlock, kBlock, products);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(featureProducts);

bool solveLastLayer(const Representation& representation, const WeightingFunction& function, float* theta) {
  double products[kFeatureRowCount * kFeatureRowCount] = {};
  HWY_DYNAMIC_DISPATCH(featureProducts)(representation, function, theta, products);
  SymmetricBand matrix(kFeatureCount, kFeatureCount - 1);
  double solution[kFeatureCount], largest = 0.0;
  for (int r = 0; r < kFeatureCount; ++r) {
    for (int c = 0; c <= r; ++c) matrix.at(r, c) = products[r * kFeatureRowCount + c];
    largest = std::max(largest, matrix.at(r, r));
    solution[r] = products[kFeatureCount * kFeatureRowCount + r];
  }
  for (int i = 0; i < kFeatureCount; ++i) matrix.at(i, i) += 1e-9 * largest;
  if (!matrix.solve(solution)) return false;
  float last_layer[kFeatureCount];
  for (int i = 0; i < kFeatureCount; ++i) {
    last_layer[i] = static_cast<float>(solution[i]);
    if (!std::isfinite(last_layer[i])) return false;
  }
  // w3, then b3, as theta holds them
  static_assert(ThetaLayout::b3 == ThetaLayout::w3 + kHiddenCount);
  std::copy_n(last_layer, kFeatureCount, theta + ThetaLayout::w3);
  return true;
}

}  // namespace nlg
#endif  // HWY_ONCE
