#include "runtime_eval/evaluator/evaluate.h"

#include "runtime_eval/evaluator/product_field.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/evaluator/evaluate.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include "runtime_eval/evaluator/tiny_network-inl.h"

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {

void evaluateVectors(const Representation& representation, const PointSet& points, const float* HWY_RESTRICT theta,
                     float* HWY_RESTRICT values) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Floats slope = hn::Set(d, representation.slope);
  for (int i = 0; i < points.padded_count; i += lanes) {
    const Floats x = hn::Load(d, &points.x[i]), y = hn::Load(d, &points.y[i]), z = hn::Load(d, &points.z[i]);
    Hidden<1> hidden;
    Floats output;
    forwardNetwork<1>(d, theta, slope, &x, &y, &z, hidden, &output);
    if (representation.tentFactor()) output = hn::Mul(output, hn::Load(d, &points.tent[i]));
    hn::StoreU(output, d, values + i);
  }
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
  HWY_DYNAMIC_DISPATCH(evaluateVectors)(representation, points, theta, values);
}

double evaluateReference(const Representation& representation, const LocalPoint& point, const double* theta) {
  if (representation.isField()) return evaluateFieldReference(representation.resolution, point, theta);
  using L = ThetaLayout;
  const double slope = representation.slope;
  const auto leaky = [slope](double value) { return value > 0 ? value : slope * value; };
  double first[kHiddenCount];
  for (int j = 0; j < kHiddenCount; ++j) {
    double sum = theta[L::b1 + j];
    for (int axis = 0; axis < 3; ++axis) sum += theta[L::w1 + 3 * j + axis] * point[axis];
    first[j] = leaky(sum);
  }
  double output = theta[L::b3];
  for (int j = 0; j < kHiddenCount; ++j) {
    double sum = theta[L::b2 + j];
    for (int i = 0; i < kHiddenCount; ++i) sum += theta[L::w2 + kHiddenCount * j + i] * first[i];
    output += theta[L::w3 + j] * leaky(sum);
  }
  return representation.tentFactor() ? output * tent(point) : output;
}

}  // namespace nlg
#endif  // HWY_ONCE
