#include "runtime_eval/evaluator/product_field.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace nlg {

void evaluateField(int resolution, const PointSet& points, const float* theta, float* values) {
  const std::vector<double> exact(theta, theta + 2 * resolution * resolution * resolution);
  for (int i = 0; i < points.padded_count; ++i)
    values[i] = static_cast<float>(evaluateFieldReference(resolution, {points.x[i], points.y[i], points.z[i]}, exact.data()));
}

void evaluateFieldCells(const PointOrder& order, const float* theta, float* values) {
  evaluateField(order.resolution, order.points, theta, values);
}

double evaluateFieldReference(int resolution, const LocalPoint& point, const double* theta) {
  int node[3];
  double share[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double position = std::clamp((static_cast<double>(point[axis]) + 1.0) * 0.5, 0.0, 1.0) * (resolution - 1);
    node[axis] = std::min(static_cast<int>(position), resolution - 2);
    share[axis] = position - node[axis];
  }
  double a = 0.0, b = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1.0;
    int index = 0, stride = 1;
    for (int axis = 0; axis < 3; ++axis, stride *= resolution) {
      const int high = corner >> axis & 1;
      weight *= high ? share[axis] : 1.0 - share[axis];
      index += (node[axis] + high) * stride;
    }
    a += weight * theta[2 * index];
    b += weight * theta[2 * index + 1];
  }
  return std::clamp(a, 0.0, 1.0) / (1.0 + std::exp(-b));
}

}  // namespace nlg
