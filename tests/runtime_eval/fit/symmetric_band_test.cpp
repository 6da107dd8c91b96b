#include "runtime_eval/fit/symmetric_band.h"

#include <gtest/gtest.h>

#include <cmath>

#include "runtime_eval/numbers/random.h"
#include "tests/runtime_eval/each_target.h"

namespace nlg {
namespace {

constexpr double kDoubleRounding = 0x1p-53;

// Positive definite: the diagonal outweighs the rest of its row.
SymmetricBand randomBand(int count, int bandwidth, uint64_t seed) {
  Random random(seed);
  SymmetricBand band(count, bandwidth);
  for (int row = 0; row < count; ++row) {
    for (int column = std::max(0, row - bandwidth); column < row; ++column) band.at(row, column) = random.uniform(-1.0, 1.0);
    band.at(row, row) = random.uniform(1.0, 2.0) + 2.0 * std::min(bandwidth, count - 1);
  }
  return band;
}

double entry(const SymmetricBand& band, int row, int column) {
  if (std::abs(row - column) > band.bandwidth()) return 0.0;
  return row < column ? band.at(column, row) : band.at(row, column);
}

std::vector<double> randomVector(int count, uint64_t seed) {
  Random random(seed);
  std::vector<double> vector(count);
  for (double& value : vector) value = random.normal();
  return vector;
}

// The matrix times a vector, term by term; `largest`: the sum of magnitudes of the row's terms.
double rowProduct(const SymmetricBand& band, int row, const std::vector<double>& vector, double* largest) {
  double sum = 0.0;
  *largest = 0.0;
  for (int column = 0; column < band.count(); ++column) {
    const double term = entry(band, row, column) * vector[column];
    sum += term;
    *largest += std::fabs(term);
  }
  return sum;
}

template <class Check>
void forEachShape(const Check& check) {
  for (int count = 1; count <= 113; count += count < 34 ? 1 : 5) {
    std::vector<int> bandwidths = {0, 1, 2, 3, 7, 8, 9, 15, 16, 17, count / 2, count - 2, count - 1};
    std::sort(bandwidths.begin(), bandwidths.end());
    bandwidths.erase(std::unique(bandwidths.begin(), bandwidths.end()), bandwidths.end());
    for (const int bandwidth : bandwidths) {
      if (bandwidth < 0 || bandwidth >= count) continue;
      SCOPED_TRACE(testing::Message() << "count " << count << ", bandwidth " << bandwidth);
      check(count, bandwidth);
    }
  }
  SCOPED_TRACE("the band of pf5");
  check(250, 63);
}

TEST(SymmetricBand, MultipliesAsTheFullMatrix) {
  forEachTarget([] {
    forEachShape([](int count, int bandwidth) {
      const SymmetricBand band = randomBand(count, bandwidth, 1);
      const std::vector<double> vector = randomVector(count, 2);
      std::vector<double> result(count, 1e300);
      band.multiply(vector.data(), result.data());
      for (int row = 0; row < count; ++row) {
        double largest;
        const double expected = rowProduct(band, row, vector, &largest);
        // either sum has at most 2 count roundings
        EXPECT_NEAR(result[row], expected, 4 * count * kDoubleRounding * largest) << "row " << row;
      }
    });
  });
}

TEST(SymmetricBand, SolvesWithASmallResidual) {
  forEachTarget([] {
    forEachShape([](int count, int bandwidth) {
      const SymmetricBand band = randomBand(count, bandwidth, 3);
      const std::vector<double> right = randomVector(count, 4);
      std::vector<double> x = right;
      SymmetricBand destroyed = band;
      ASSERT_TRUE(destroyed.solve(x.data()));
      // Higham, Accuracy and Stability of Numerical Algorithms (2002), theorem 10.4: (A + E) x = b, |E| <= g |U^T| |U|, g =
      // (3 n + 1) roundings; a row of |U^T| |U| adds up to at most sqrt(n) times the largest row sum of |A| for such matrices.
      double largest_row = 0.0, largest_x = 0.0;
      for (int row = 0; row < count; ++row) {
        double sum = 0.0;
        for (int column = 0; column < count; ++column) sum += std::fabs(entry(band, row, column));
        largest_row = std::max(largest_row, sum);
        largest_x = std::max(largest_x, std::fabs(x[row]));
      }
      const double bound = (3 * count + 1) * kDoubleRounding * std::sqrt(count) * largest_row * largest_x;
      for (int row = 0; row < count; ++row) {
        double largest;
        EXPECT_NEAR(rowProduct(band, row, x, &largest), right[row], bound) << "row " << row;
      }
    });
  });
}

TEST(SymmetricBand, SolvesHilbertMatricesToRoundingOrRefusesThem) {
  // their condition grows beyond 1e16 from 12 rows on. Cholesky is backward stable: residuals stay a small multiple of the count times
  // a rounding (Higham 2002, theorem 10.4), whatever the condition
  bool refuses = false;
  for (int count = 2; count <= 24; count += 2) {
    SymmetricBand band(count, count - 1);
    for (int row = 0; row < count; ++row) {
      for (int column = 0; column <= row; ++column) band.at(row, column) = 1.0 / (row + column + 1);
    }
    const SymmetricBand hilbert = band;
    std::vector<double> x(count, 1.0);
    const bool is_solved = band.solve(x.data());
    EXPECT_TRUE(is_solved || count >= 12) << count << " rows";
    refuses = refuses || !is_solved;
    if (!is_solved) continue;
    double largest_x = 0.0, largest;
    for (const double value : x) largest_x = std::max(largest_x, std::fabs(value));
    for (int row = 0; row < count; ++row) {
      EXPECT_NEAR(rowProduct(hilbert, row, x, &largest), 1.0, count * count * kDoubleRounding * (largest_x * count + 1.0))
          << count << " rows";
    }
  }
  EXPECT_TRUE(refuses);
}

}  // namespace
}  // namespace nlg
