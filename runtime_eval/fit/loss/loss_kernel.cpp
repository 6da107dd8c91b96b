#include "runtime_eval/fit/loss/loss_kernel.h"

#include "runtime_eval/evaluator/kernel_shape.h"

namespace nlg {

// Fields and codes have one minibatch, all of their places: there first is 0 and count all.
double lossAndGradient(const Representation& representation, int first, int count, const float* phi, const float* mask,
                       const float* theta, float* gradient) {
  const PointOrder& order = pointOrder(representation);
  if (representation.isField()) return fieldLossAndGradient(order, phi, mask, theta, gradient);
  if (representation.isCode()) return codeLossAndGradient(*representation.dictionary, phi, mask, theta, gradient);
  return networkLossAndGradient(representation, order.points, first, count, phi, mask, theta, gradient);
}

double loss(const Representation& representation, int first, int count, const float* phi, const float* mask, const float* theta) {
  const PointOrder& order = pointOrder(representation);
  if (representation.isField()) return fieldLoss(order, phi, mask, theta);
  if (representation.isCode()) return codeLoss(*representation.dictionary, phi, mask, theta);
  return networkLoss(representation, order.points, first, count, phi, mask, theta);
}

}  // namespace nlg
