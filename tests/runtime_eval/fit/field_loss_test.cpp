#include "runtime_eval/fit/loss/loss_kernel.h"

#include <gtest/gtest.h>

#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/fit/reference_loss.h"
#include "tests/runtime_eval/sample_fields.h"

namespace nlg {
namespace {

struct Gradient {
  double sum = 0.0;
  std::vector<double> values;
};

Gradient reference(const PointOrder& order, const WeightingFunction& function, const std::vector<double>& theta) {
  Gradient result{0.0, std::vector<double>(theta.size())};
  result.sum =
      fieldLossAndGradientReference(order, function.phi.data(), function.mask.data(), theta.data(), result.values.data());
  return result;
}

Gradient vectorised(const PointOrder& order, const WeightingFunction& function, const Theta& theta) {
  std::vector<float> values(theta.size(), 1e30f);
  const double sum = fieldLossAndGradient(order, function.phi.data(), function.mask.data(), theta.data(), values.data());
  return {sum, {values.begin(), values.end()}};
}

TEST(FieldLossReference, HasTheGradientOfCentralDifferences) {
  // A in [0.1, 0.9]: no point is at the clamp, the loss is smooth. Its third derivative by one node is below 1 a point, so that
  // truncation is below h² / 6 * 8192 = 1.4e-7; rounding is below 8192 * 1e-16 * 8192 / h = 7e-4 at worst, some 1e-7 in fact
  constexpr double kStep = 1e-5;
  for (const int resolution : kFieldResolutions) {
    const PointOrder& order = cellOrder(resolution);
    WeightingFunction function = decoded(noiseSample(1).view(), order);
    weigh(&function.mask);
    const std::vector<double> theta = toDouble(randomField(resolution, 2, 0.1, 0.9));
    const Gradient at = reference(order, function, theta);
    for (size_t i = 0; i < theta.size(); i += theta.size() / 29) {
      std::vector<double> low = theta, high = theta;
      low[i] -= kStep;
      high[i] += kStep;
      const double difference = (reference(order, function, high).sum - reference(order, function, low).sum) / (2 * kStep);
      EXPECT_NEAR(at.values[i], difference, 1e-6) << "resolution " << resolution << ", theta " << i;
    }
  }
}

// By theta: sum over valid points of the cells around the node.
std::vector<double> pointsAround(const PointOrder& order, const WeightingFunction& function) {
  std::vector<double> result(2 * order.resolution * order.resolution * order.resolution, 0.0);
  const std::vector<double> theta(result.size(), 0.5);
  for (int place = 0; place < order.placeCount(); ++place) {
    const FieldDerivative field = fieldDerivativeReference(order.resolution, placePosition(order, place), theta.data());
    for (const int node : field.node) {
      for (int channel = 0; channel < 2; ++channel) result[2 * node + channel] += function.mask[place];
    }
  }
  return result;
}

int largestCell(const PointOrder& order) {
  int largest = 0;
  for (size_t c = 1; c < order.cell_begin.size(); ++c) largest = std::max(largest, order.cell_begin[c] - order.cell_begin[c - 1]);
  return largest;
}

TEST(FieldLoss, AgreesWithTheReference) {
  for (const int resolution : kFieldResolutions) {
    const PointOrder& order = cellOrder(resolution);
    for (const StoredSample& sample : {noiseSample(5), wallSample(6)}) {
      const Theta theta = randomField(resolution, 7, -0.5, 1.5);
      WeightingFunction function = decoded(sample.view(), order);
      maskClamp(order, theta, trilinearError(resolution, theta, 0), &function.mask);
      weigh(&function.mask);
      const Gradient expected = reference(order, function, toDouble(theta));
      const std::vector<double> around = pointsAround(order, function);
      // A term of the gradient is 2 r g: the residual and g, both at most 1, each carry the field's error; the sum of a cell has
      // at most a rounding a point and 16 more, each of up to 2 a point.
      const double term = 2 * (2 * fieldError(resolution, theta) + kFloatRounding * (largestCell(order) + 16));
      forEachTarget([&] {
        SCOPED_TRACE(testing::Message() << "resolution " << resolution);
        const Gradient got = vectorised(order, function, theta);
        EXPECT_NEAR(got.sum, expected.sum, term * function.validCount());
        EXPECT_NEAR(fieldLoss(order, function.phi.data(), function.mask.data(), theta.data()), expected.sum,
                    term * function.validCount());
        for (size_t i = 0; i < theta.size(); ++i)
          ASSERT_NEAR(got.values[i], expected.values[i], term * around[i]) << "theta " << i;
      });
    }
  }
}

TEST(FieldLoss, IgnoresWhatTheMaskLeavesOut) {
  for (const int resolution : kFieldResolutions) {
    const PointOrder& order = cellOrder(resolution);
    const Theta theta = randomField(resolution, 8, -0.5, 1.5);
    const WeightingFunction function = decoded(wallSample(9).view(), order);
    WeightingFunction other = function;
    for (int place = 0; place < order.placeCount(); ++place) {
      if (other.mask[place] == 0.0f) other.phi[place] = 1e6f;
    }
    forEachTarget([&] {
      const Gradient a = vectorised(order, function, theta), b = vectorised(order, other, theta);
      EXPECT_EQ(a.sum, b.sum) << resolution;
      EXPECT_EQ(a.values, b.values) << resolution;
    });
  }
}

}  // namespace
}  // namespace nlg
