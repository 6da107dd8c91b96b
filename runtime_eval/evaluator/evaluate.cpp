#include "runtime_eval/evaluator/evaluate.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "runtime_eval/evaluator/product_field.h"
#include "runtime_eval/numbers/logistic.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/evaluator/evaluate.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include "runtime_eval/evaluator/tiny_network-inl.h"

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {

template <NetworkShape kShape>
void evaluateShape(const Representation& representation, const PointSet& points, const float* HWY_RESTRICT theta,
                   float* HWY_RESTRICT values) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Floats slope = hn::Set(d, representation.slope);
  const bool tent_factor = representation.tentFactor();
  for (int i = 0; i < points.padded_count; i += lanes) {
    const Floats x = hn::Load(d, &points.x[i]), y = hn::Load(d, &points.y[i]), z = hn::Load(d, &points.z[i]);
    Hidden<kShape, 1> hidden;
    Floats output;
    forwardNetwork<kShape, 1>(d, theta, slope, &x, &y, &z, hidden, &output);
    output = outputValue<kShape.output>(d, output).value;
    if (tent_factor) output = hn::Mul(output, hn::Load(d, &points.tent[i]));
    hn::StoreU(output, d, values + i);
  }
}

void evaluateVectors(const Representation& representation, const PointSet& points, const float* HWY_RESTRICT theta,
                     float* HWY_RESTRICT values) {
  withNetworkShape(representation, [&]<NetworkShape kShape>() { evaluateShape<kShape>(representation, points, theta, values); });
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(evaluateVectors);

void evaluate(const Representation& representation, const PointSet& points, const float* theta, float* values) {
  if (representation.isField()) {
    evaluateField(representation.resolution, points, theta, values);
    return;
  }
  if (representation.isCode()) {
    alignas(64) float logits[kMaxBrickStride];
    roundedLogits(*representation.dictionary, theta, logits);
    evaluateLogits(representation.resolution, points, logits, values);
    return;
  }
  HWY_DYNAMIC_DISPATCH(evaluateVectors)(representation, points, theta, values);
}

// In pieces that the first-level cache holds.
void evaluate(const Representation& representation, const LocalPoint* points, size_t count, const float* theta, float* phi) {
  constexpr size_t kPointsAtOnce = 512;
  AlignedFloats values(kPointsAtOnce);
  for (size_t first = 0; first < count; first += kPointsAtOnce) {
    const size_t piece = std::min(kPointsAtOnce, count - first);
    evaluate(representation, makePointSet(points + first, piece), theta, values.data());
    std::copy_n(values.data(), piece, phi + first);
  }
}

double evaluateReference(const Representation& representation, const LocalPoint& point, const double* theta) {
  if (representation.isField()) return evaluateFieldReference(representation.resolution, point, theta);
  if (representation.isCode()) return evaluateCodeReference(*representation.dictionary, point, theta);
  return evaluateNetworkReference(representation.network(), representation.slope, point, theta);
}

double evaluateNetworkReference(const NetworkKind& network, double slope, const LocalPoint& point, const double* theta) {
  const NetworkShape& shape = network.shape;
  const auto activated = [slope](double sum) { return sum > 0 ? sum : slope * sum; };
  // h, g and y of docs/theory/math.md §4, in double and without vectors: what the kernels are tested against
  std::vector<double> hidden(shape.first);
  for (int j = 0; j < shape.first; ++j) {
    double sum = theta[shape.b1() + j];
    for (int axis = 0; axis < 3; ++axis) sum += theta[shape.w1() + 3 * j + axis] * point[axis];
    hidden[j] = activated(sum);
  }
  if (shape.second > 0) {
    const std::vector<double> first = hidden;
    hidden.resize(shape.second);
    for (int j = 0; j < shape.second; ++j) {
      double sum = theta[shape.b2() + j];
      for (int i = 0; i < shape.first; ++i) sum += theta[shape.w2() + shape.first * j + i] * first[i];
      hidden[j] = activated(sum);
    }
  }
  double output = theta[shape.b3()];
  for (int j = 0; j < shape.last(); ++j) output += theta[shape.w3() + j] * hidden[j];
  if (shape.output == OutputFunction::sigmoid) output = logistic(output);
  return network.tent_factor ? output * tent(point) : output;
}

}  // namespace nlg
#endif  // HWY_ONCE
