#include "runtime_eval/fit/field_loss.h"

#include <algorithm>
#include <vector>

namespace nlg {

double fieldLossAndGradient(const PointOrder& order, const float* phi, const float* mask, const float* theta, float* gradient) {
  const int count = 2 * order.resolution * order.resolution * order.resolution;
  const std::vector<double> exact(theta, theta + count);
  std::vector<double> sums(count);
  const double sum = fieldLossAndGradientReference(order, phi, mask, exact.data(), sums.data());
  std::copy(sums.begin(), sums.end(), gradient);
  return sum;
}

double fieldLoss(const PointOrder& order, const float* phi, const float* mask, const float* theta) {
  std::vector<float> gradient(2 * order.resolution * order.resolution * order.resolution);
  return fieldLossAndGradient(order, phi, mask, theta, gradient.data());
}

double fieldLossAndGradientReference(const PointOrder&, const float*, const float*, const double*, double*) { return 0; }

}  // namespace nlg
