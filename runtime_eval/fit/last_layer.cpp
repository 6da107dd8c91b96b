#include "runtime_eval/fit/last_layer.h"
#include "runtime_eval/evaluator/kernel_shape.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/fit/last_layer.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include "runtime_eval/evaluator/tiny_network-inl.h"
#include "runtime_eval/fit/gram-inl.h"

#ifndef NLG_LAST_LAYER_CONSTANTS
#define NLG_LAST_LAYER_CONSTANTS
namespace nlg {
// the last hidden values and the constant 1, then phi, each masked and the former times the tent; zero rows up to whole tiles
constexpr int featureCount(const NetworkShape& shape) { return shape.last() + 1; }
constexpr int featureRowCount(const NetworkShape& shape) { return (featureCount(shape) + 1 + 3) / 4 * 4; }
constexpr int maxFeatureRowCount() {
  int count = 0;
  for (const NetworkKind& network : kNetworks) count = std::max(count, featureRowCount(network.shape));
  return count;
}
inline constexpr int kMaxFeatureRowCount = maxFeatureRowCount();
}  // namespace nlg
#endif

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {

// What the equations are summed over: places from `first` on, and their samples.
struct Targets {
  int first, count;
  const float* HWY_RESTRICT phi;
  const float* HWY_RESTRICT mask;
};

template <NetworkShape kShape>
void shapeFeatureProducts(const Representation& representation, const Targets& targets, const float* HWY_RESTRICT theta,
                          double* HWY_RESTRICT products) {
  constexpr int kBlock = 256, kRowCount = featureRowCount(kShape), kLast = kShape.last();
  alignas(64) float rows[kRowCount * kBlock] = {};
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Floats slope = hn::Set(d, representation.slope);
  const bool tent_factor = representation.tentFactor();
  const PointSet& points = stratifiedSupportPoints();
  // a block of rows stays in the level-1 cache between the forward pass and the products
  for (int begin = 0; begin < targets.count; begin += kBlock) {
    const int block_count = std::min(kBlock, targets.count - begin);
    for (int i = 0; i < block_count; i += lanes) {
      const int at = targets.first + begin + i;
      const Floats x = hn::Load(d, &points.x[at]), y = hn::Load(d, &points.y[at]), z = hn::Load(d, &points.z[at]);
      const Floats mask = hn::Load(d, targets.mask + begin + i);
      const Floats scale = tent_factor ? hn::Mul(mask, hn::Load(d, &points.tent[at])) : mask;
      Hidden<kShape, 1> hidden;
      Floats output;
      forwardNetwork<kShape, 1>(d, theta, slope, &x, &y, &z, hidden, &output);
      for (int j = 0; j < kLast; ++j) hn::Store(hn::Mul(scale, hidden.last().value[j][0]), d, rows + j * kBlock + i);
      hn::Store(scale, d, rows + kLast * kBlock + i);
      hn::Store(hn::Mul(mask, hn::Load(d, targets.phi + begin + i)), d, rows + (kLast + 1) * kBlock + i);
    }
    // the products of features and target hold both sides of the normal equations
    addGram(rows, kRowCount, kBlock, block_count, products);
  }
}

// products   featureRowCount²: products of all rows are added, lower triangle of tiles, in float over 256 points, then in double
void featureProducts(const Representation& representation, const float* phi, const float* mask, int first, int count,
                     const float* HWY_RESTRICT theta, double* HWY_RESTRICT products) {
  withNetworkShape(representation, [&]<NetworkShape kShape>() {
    if constexpr (kShape.output == OutputFunction::linear)
      shapeFeatureProducts<kShape>(representation, {first, count, phi, mask}, theta, products);
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(featureProducts);

bool solveLastLayer(const Representation& representation, const WeightingFunction& function, float* theta) {
  return solveLastLayer(representation, 0, static_cast<int>(function.phi.size()), function.phi.data(), function.mask.data(),
                        theta);
}

bool solveLastLayer(const Representation& representation, int first, int count, const float* phi, const float* mask,
                    float* theta) {
  SymmetricBand equations;
  return solveLastLayer(representation, first, count, phi, mask, theta, &equations);
}

bool solveLastLayer(const Representation& representation, int first, int count, const float* phi, const float* mask, float* theta,
                    SymmetricBand* equations, double ridge) {
  if (!representation.hasLinearOutput()) return false;
  const NetworkShape& shape = representation.shape();
  const int feature_count = featureCount(shape), row_count = featureRowCount(shape);
  double products[kMaxFeatureRowCount * kMaxFeatureRowCount] = {};
  HWY_DYNAMIC_DISPATCH(featureProducts)(representation, phi, mask, first, count, theta, products);
  SymmetricBand& matrix = *equations;
  matrix.reset(feature_count, feature_count - 1);
  // the triangle of the features is the matrix, the row of phi the right-hand side
  double solution[kMaxFeatureRowCount], largest = 0.0;
  for (int r = 0; r < feature_count; ++r) {
    for (int c = 0; c <= r; ++c) matrix.at(r, c) = products[r * row_count + c];
    largest = std::max(largest, matrix.at(r, r));
    solution[r] = products[feature_count * row_count + r];
  }
  // the ridge is relative to each entry; a billionth of the largest keeps the system regular where a unit is dead
  for (int i = 0; i < feature_count; ++i) matrix.at(i, i) += ridge * matrix.at(i, i) + 1e-9 * largest;
  if (!matrix.solve(solution)) return false;
  // theta changes only if all of the solution is finite
  float last_layer[kMaxFeatureRowCount];
  for (int i = 0; i < feature_count; ++i) {
    last_layer[i] = static_cast<float>(solution[i]);
    if (!std::isfinite(last_layer[i])) return false;
  }
  // w3, then b3, as theta holds them
  std::copy_n(last_layer, feature_count, theta + shape.w3());
  return true;
}

}  // namespace nlg
#endif  // HWY_ONCE
