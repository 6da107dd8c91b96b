#include "runtime_eval/evaluator/product_field.h"

#include <gtest/gtest.h>

#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/sample_fields.h"

namespace nlg {
namespace {

std::vector<float> evaluatedAt(int resolution, const std::vector<LocalPoint>& points, const Theta& theta) {
  const PointSet set = makePointSet(points);
  std::vector<float> values(set.padded_count);
  evaluateField(resolution, set, theta.data(), values.data());
  values.resize(points.size());
  return values;
}

std::vector<float> evaluatedCells(int resolution, const Theta& theta) {
  std::vector<float> values(cellOrder(resolution).placeCount());
  evaluateFieldCells(cellOrder(resolution), theta.data(), values.data());
  return values;
}

TEST(ProductField, AgreesWithTheReferenceAtAnyPoints) {
  for (const int resolution : kFieldResolutions) {
    for (const int count : {1, 15, 16, 17, 127, 129, 1000}) {
      SCOPED_TRACE(testing::Message() << "resolution " << resolution << ", points " << count);
      const std::vector<LocalPoint> points = testPoints(count);
      const Theta theta = randomField(resolution, 12, -0.5, 1.5);
      const std::vector<double> exact = toDouble(theta);
      const double bound = fieldError(resolution, theta);
      forEachTarget([&] {
        const std::vector<float> values = evaluatedAt(resolution, points, theta);
        for (int i = 0; i < count; ++i) {
          ASSERT_NEAR(values[i], evaluateFieldReference(resolution, points[i], exact.data()), bound) << "point " << i;
        }
      });
    }
  }
}

// A = 1 and B = b everywhere: interpolation is exact, the field is the sigmoid alone.
float sigmoidOf(float b) { return evaluatedAt(3, {{0.3f, -0.6f, 0.1f}}, constantField(3, 1.0f, b))[0]; }

TEST(ProductField, HasASigmoidWithinThreeUnitsInTheLastPlace) {
  forEachTarget([&] {
    for (int i = -8700; i <= 8700; ++i) {
      const float b = static_cast<float>(i) * 0.01f, value = sigmoidOf(b);
      const double expected = 1.0 / (1.0 + std::exp(-static_cast<double>(b)));
      const float rounded = static_cast<float>(expected);
      const double unit = std::nextafter(rounded, 2.0f) - static_cast<double>(rounded);
      ASSERT_LE(std::fabs(value - expected), 3.0 * unit) << "b = " << b;
    }
    for (float b = 1e-40f; b < 80.0f; b *= 3.7f) {
      ASSERT_NEAR(sigmoidOf(b), 1.0 / (1.0 + std::exp(-static_cast<double>(b))), 3 * 0x1p-24) << "b = " << b;
      ASSERT_NEAR(sigmoidOf(-b), 1.0 / (1.0 + std::exp(static_cast<double>(b))), 3 * 0x1p-24) << "b = " << -b;
    }
  });
}

TEST(ProductField, StaysTheSameOnAGridThatHoldsAllItsNodes) {
  constexpr int kNested[][2] = {{3, 3}, {3, 5}, {3, 7}, {3, 9}, {5, 9}};
  for (const auto [from, to] : kNested) {
    SCOPED_TRACE(testing::Message() << from << " to " << to);
    const Theta theta = randomField(from, 15, -0.5, 1.5);
    Theta finer(Representation::productField(to).thetaCount());
    resampleField(from, theta.data(), to, finer.data());
    const std::vector<double> exact = toDouble(theta), exact_finer = toDouble(finer);
    for (const LocalPoint& point : testPoints(500)) {
      // one rounding of each new node
      ASSERT_NEAR(evaluateFieldReference(to, point, exact_finer.data()), evaluateFieldReference(from, point, exact.data()),
                  fieldError(from, theta));
    }
  }
}

TEST(ProductField, TakesTheOldFieldsValuesAtTheNodesOfAnyOtherGrid) {
  constexpr int kPairs[][2] = {{5, 7}, {7, 5}, {9, 3}, {7, 9}};
  for (const auto [from, to] : kPairs) {
    SCOPED_TRACE(testing::Message() << from << " to " << to);
    const Theta theta = randomField(from, 16, 0.0, 1.0);
    Theta other(Representation::productField(to).thetaCount());
    resampleField(from, theta.data(), to, other.data());
    const std::vector<double> exact = toDouble(theta);
    for (int i = 0; i < to * to * to; ++i) {
      const auto along = [&](int node) { return static_cast<float>(2.0 * node / (to - 1) - 1.0); };
      const double expected =
          evaluateFieldReference(from, {along(i % to), along(i / to % to), along(i / (to * to))}, exact.data());
      ASSERT_NEAR(other[2 * i] / (1.0 + std::exp(-static_cast<double>(other[2 * i + 1]))), expected, fieldError(from, theta))
          << i;
    }
  }
}

TEST(ProductField, StaysInTheUnitIntervalHoweverLargeItsNodes) {
  for (const int resolution : kFieldResolutions) {
    Theta theta = randomField(resolution, 17, -1.0, 1.0);
    for (float& node : theta) node = std::copysign(1e37f, node);
    const std::vector<LocalPoint> points = testPoints(1000);
    forEachTarget([&] {
      std::vector<float> values = evaluatedCells(resolution, theta);
      for (const float value : evaluatedAt(resolution, points, theta)) values.push_back(value);
      for (const float value : values) ASSERT_TRUE(value >= 0.0f && value <= 1.0f) << resolution << ": " << value;
    });
  }
}

}  // namespace
}  // namespace nlg
