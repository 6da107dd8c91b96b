#include "runtime_eval/fit/normal_equations.h"

#include <gtest/gtest.h>

#include "runtime_eval/fit/loss/loss_kernel.h"
#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/fit/reference_loss.h"
#include "tests/runtime_eval/sample_fields.h"

namespace nlg {
namespace {

// J^T J, J^T r and r² as full matrices, point by point; and what rounding errors are a multiple of: the sums over valid points of
// both weights, of the cell's points, and of points.
struct FullEquations {
  int count;
  std::vector<double> hessian, weights, gradient, points;
  double square_sum = 0.0;
};

FullEquations fullEquations(const PointOrder& order, const WeightingFunction& function, const Theta& theta) {
  const int count = static_cast<int>(theta.size());
  const std::vector<double> exact = toDouble(theta), flat(count, 0.0);
  // here the derivatives by A are the weights of the nodes
  const std::vector<double> plain = toDouble(constantField(order.resolution, 0.5f, 1e3f));
  FullEquations full{count, std::vector<double>(count * count), std::vector<double>(count * count), flat, flat};
  for (int place = 0; place < order.placeCount(); ++place) {
    if (function.mask[place] == 0.0f) continue;
    const LocalPoint point = placePosition(order, place);
    const FieldDerivative field = fieldDerivativeReference(order.resolution, point, exact.data());
    const FieldDerivative weight = fieldDerivativeReference(order.resolution, point, plain.data());
    const double residual = field.value - function.phi[place];
    full.square_sum += residual * residual;
    for (int i = 0; i < 16; ++i) {
      const int row = 2 * field.node[i / 2] + i % 2;
      const double by_row = i % 2 ? field.by_b[i / 2] : field.by_a[i / 2];
      full.gradient[row] += residual * by_row;
      full.points[row] += 1.0;
      for (int j = 0; j < 16; ++j) {
        const size_t at = static_cast<size_t>(row) * count + 2 * field.node[j / 2] + j % 2;
        full.hessian[at] += by_row * (j % 2 ? field.by_b[j / 2] : field.by_a[j / 2]);
        full.weights[at] += weight.by_a[i / 2] * weight.by_a[j / 2];
      }
    }
  }
  return full;
}

TEST(FieldNormalEquations, AgreesWithTheFullProductsOfTheReference) {
  for (const int resolution : kFieldResolutions) {
    const PointOrder& order = cellOrder(resolution);
    const Theta theta = randomField(resolution, 21, -0.5, 1.5);
    WeightingFunction function = decoded(wallSample(22).view(), order);
    maskClamp(order, theta, trilinearError(resolution, theta, 0), &function.mask);
    const FullEquations full = fullEquations(order, function, theta);
    // Both derivatives carry the field's error; sums of a cell have at most a rounding a point, and 20 more. All are at most 1
    // times the weights: relative to the sum of weights, because no weight is negative.
    int largest_cell = 0;
    for (size_t c = 1; c < order.cell_begin.size(); ++c) {
      largest_cell = std::max(largest_cell, order.cell_begin[c] - order.cell_begin[c - 1]);
    }
    const double term = 2 * fieldError(resolution, theta) + kFloatRounding * (largest_cell + 20);
    NormalEquations equations;
    forEachTarget([&] {
      SCOPED_TRACE(testing::Message() << "resolution " << resolution);
      fieldNormalEquations(order, function, theta.data(), &equations);
      ASSERT_EQ(equations.hessian.count(), full.count);
      const int bandwidth = equations.hessian.bandwidth();
      EXPECT_EQ(bandwidth, 2 * (1 + resolution + resolution * resolution) + 1);
      EXPECT_NEAR(equations.square_sum, full.square_sum, term * function.validCount());
      for (int row = 0; row < full.count; ++row) {
        ASSERT_NEAR(equations.gradient[row], full.gradient[row], term * full.points[row]) << "row " << row;
        for (int column = 0; column <= row; ++column) {
          const size_t at = static_cast<size_t>(row) * full.count + column;
          const double got = row - column <= bandwidth ? equations.hessian.at(row, column) : 0.0;
          ASSERT_NEAR(got, full.hessian[at], term * full.weights[at]) << "row " << row << ", column " << column;
        }
      }
    });
  }
}

TEST(FieldNormalEquations, HasHalfTheGradientOfTheLoss) {
  for (const int resolution : kFieldResolutions) {
    const PointOrder& order = cellOrder(resolution);
    const Theta theta = randomField(resolution, 23, 0.0, 1.0);
    const WeightingFunction function = decoded(noiseSample(24).view(), order);
    std::vector<float> gradient(theta.size());
    NormalEquations equations;
    forEachTarget([&] {
      const double sum = fieldLossAndGradient(order, function.phi.data(), function.mask.data(), theta.data(), gradient.data());
      fieldNormalEquations(order, function, theta.data(), &equations);
      EXPECT_NEAR(equations.square_sum, sum, 1e-6 * sum) << resolution;
      // the same sums in the same order, only factors 2 and 0 or 1 are taken at other places
      for (size_t i = 0; i < theta.size(); ++i) EXPECT_EQ(2 * equations.gradient[i], gradient[i]) << resolution << ' ' << i;
    });
  }
}

}  // namespace
}  // namespace nlg
