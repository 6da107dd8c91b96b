#include "validate/generators/statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

TEST(Quantile, InterpolatesBetweenOrderStatistics) {
  std::vector<double> values = {40, 10, 30, 20};
  EXPECT_EQ(quantile(values, 0.0), 10);
  EXPECT_EQ(quantile(values, 1.0), 40);
  EXPECT_EQ(quantile(values, 0.5), 25);
  EXPECT_EQ(quantile(values, 1.0 / 3.0), 20);
  EXPECT_DOUBLE_EQ(quantile(values, 0.9), 37);
  std::vector<double> one = {7}, none;
  for (const double share : {0.0, 0.5, 1.0}) {
    EXPECT_EQ(quantile(one, share), 7);
    EXPECT_EQ(quantile(none, share), 0);
  }
}

TEST(Quantile, EqualsTheSortedListsOnRandomValues) {
  Random random(1);
  for (const int count : {2, 3, 10, 101, 1000}) {
    std::vector<double> values(count);
    for (double& value : values) value = random.normal();
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    for (const double share : {0.0, 0.01, 0.5, 0.95, 0.99, 1.0}) {
      const double position = share * (count - 1);
      const auto low = static_cast<size_t>(position);
      const double expected =
          sorted[low] + (position - std::floor(position)) * (sorted[std::min<size_t>(low + 1, count - 1)] - sorted[low]);
      ASSERT_DOUBLE_EQ(quantile(values, share), expected) << count << " values, share " << share;
    }
  }
}

TEST(PooledMagnitudes, AreWithinABinOfTheTrueQuantiles) {
  Random random(2);
  PooledMagnitudes pooled;
  std::vector<double> magnitudes;
  double sum = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const double value = 0.3 * random.normal();
    pooled.add(value);
    magnitudes.push_back(std::fabs(value));
    sum += std::fabs(value);
  }
  EXPECT_NEAR(pooled.mean(), sum / 20000, 0x1p-31) << "each is rounded to a whole number of 2^-30";
  std::sort(magnitudes.begin(), magnitudes.end());
  for (const double share : {0.1, 0.5, 0.9, 0.99, 1.0}) {
    // the smallest value with at least this share at or below it, rounded up to its bin's upper edge
    const double exact = magnitudes[static_cast<size_t>(std::ceil(share * 20000)) - 1];
    EXPECT_GE(pooled.quantile(share), exact) << "share " << share;
    EXPECT_LE(pooled.quantile(share), exact + 1.0 / 2048) << "share " << share;
  }
}

TEST(PooledMagnitudes, AddUp) {
  PooledMagnitudes a, b, both;
  for (int i = 0; i < 100; ++i) a.add(i / 200.0), both.add(i / 200.0);
  for (int i = 0; i < 50; ++i) b.add(-i / 30.0), both.add(-i / 30.0);
  a.add(b);
  EXPECT_NEAR(a.mean(), both.mean(), 1e-15);
  for (const double share : {0.01, 0.3, 0.6, 0.99}) EXPECT_EQ(a.quantile(share), both.quantile(share)) << share;
}

TEST(PooledMagnitudes, AreZeroWithoutValues) {
  EXPECT_EQ(PooledMagnitudes().mean(), 0.0);
  EXPECT_EQ(PooledMagnitudes().quantile(0.99), 0.0);
}

}  // namespace
}  // namespace nlg
