#include "runtime_eval/fit/loss_kernel.h"

#include "runtime_eval/fit/field_loss.h"
#include "runtime_eval/fit/network_loss.h"

namespace nlg {

double lossAndGradient(const Representation& representation, int batch, const float* phi, const float* mask, const float* theta,
                       float* gradient) {
  const PointOrder& order = pointOrder(representation);
  if (representation.isField()) return fieldLossAndGradient(order, phi, mask, theta, gradient);
  const int first = order.batch_begin[batch];
  return networkLossAndGradient(representation, order.points, first, order.batch_begin[batch + 1] - first, phi, mask, theta,
                                gradient);
}

double loss(const Representation& representation, int batch, const float* phi, const float* mask, const float* theta) {
  const PointOrder& order = pointOrder(representation);
  if (representation.isField()) return fieldLoss(order, phi, mask, theta);
  const int first = order.batch_begin[batch];
  return networkLoss(representation, order.points, first, order.batch_begin[batch + 1] - first, phi, mask, theta);
}

}  // namespace nlg
