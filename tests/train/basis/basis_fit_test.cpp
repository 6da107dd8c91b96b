#include "train/basis/basis_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "tests/runtime_eval/sample_functions.h"
#include "tool/error.h"

// A fit solves eight eigenproblems of 1024²: seconds. Cases share them, and this executable is one test for CTest.
namespace nlg {
namespace {

constexpr int kFunctionCount = 40;

const std::vector<uint8_t>& functions() {
  static const std::vector<uint8_t> phi = [] {
    std::vector<uint8_t> all;
    for (int n = 0; n < kFunctionCount; ++n) {
      const StoredSample sample = wallSample(100 + static_cast<uint64_t>(n));
      all.insert(all.end(), sample.phi.begin(), sample.phi.end());
    }
    return all;
  }();
  return phi;
}

const Basis& wideBasis() {
  static const Basis basis = [] {
    BasisFit fit;
    fit.add(functions().data(), kFunctionCount);
    return fit.fit(kSupportPointCount);
  }();
  return basis;
}

int classOf(const BasisData& data, int component) {
  int parity_class = 0;
  for (int end = data.class_count[0]; component >= end; end += data.class_count[++parity_class]) {
  }
  return parity_class;
}

// Of component a of one basis and b of the other.
double dot(const BasisData& of_a, int a, const BasisData& of_b, int b) {
  const float *x = &of_a.components[size_t(a) * kOctantPointCount], *y = &of_b.components[size_t(b) * kOctantPointCount];
  return std::inner_product(x, x + kOctantPointCount, y, 0.0, std::plus<>(), [](double p, double q) { return p * q; });
}

// Component k at support point p: its class's sign by mirror, 1/sqrt(8) for each.
double componentAt(const BasisData& data, int k, int p) {
  return mirrorSign(classOf(data, k), p / kOctantPointCount) *
         data.components[size_t(k) * kOctantPointCount + p % kOctantPointCount] / std::sqrt(8.0);
}

// Mean over all functions and their mirror images at point p, in [0, 1].
std::vector<double> mirroredMean() {
  std::vector<double> mean(kSupportPointCount, 0.0);
  for (int n = 0; n < kFunctionCount; ++n) {
    for (int m = 0; m < kMirrorCount; ++m) {
      for (int p = 0; p < kSupportPointCount; ++p)
        mean[p] += functions()[size_t(n) * kSupportPointCount + (p ^ (m * kOctantPointCount))];
    }
  }
  for (double& value : mean) value /= 255.0 * kFunctionCount * kMirrorCount;
  return mean;
}

TEST(BasisFit, HasOrthonormalComponents) {
  const BasisData& data = wideBasis().data;
  for (int a = 0; a < data.coefficientCount(); ++a) {
    for (int b = 0; b <= a; ++b) {
      if (classOf(data, a) != classOf(data, b)) continue;  // orthogonal by their signs
      // entries are rounded to float: products of two unit rows are off by at most 2 u
      ASSERT_NEAR(dot(data, a, data, b), a == b ? 1.0 : 0.0, 4 * kFloatRounding) << "components " << a << " and " << b;
    }
  }
}

TEST(BasisFit, HasTheMeanOfAllMirrorImages) {
  const BasisData& data = wideBasis().data;
  const std::vector<double> mean = mirroredMean();
  for (int p = 0; p < kSupportPointCount; ++p) {
    const int i = p % kOctantPointCount;
    // a mean that is the same in all octants is class 0 alone, times sqrt(8)
    ASSERT_NEAR(data.mean[i] / std::sqrt(8.0), mean[p], 2 * kFloatRounding) << "point " << p;
    if (p >= kOctantPointCount) {
      ASSERT_EQ(data.mean[p], 0.0f) << "entry " << p;
    }
  }
}

TEST(BasisFit, HasTheVarianceOfTheProjectedMirrorImages) {
  const BasisData& data = wideBasis().data;
  const std::vector<double> mean = mirroredMean();
  for (int k = 0; k < data.coefficientCount(); k += 11) {
    std::vector<double> row(kSupportPointCount);
    for (int p = 0; p < kSupportPointCount; ++p) row[p] = componentAt(data, k, p);
    double square_sum = 0.0, sum = 0.0;
    for (int n = 0; n < kFunctionCount; ++n) {
      for (int m = 0; m < kMirrorCount; ++m) {
        double coefficient = 0.0;
        for (int p = 0; p < kSupportPointCount; ++p) {
          coefficient += row[p] * (functions()[size_t(n) * kSupportPointCount + (p ^ (m * kOctantPointCount))] / 255.0 - mean[p]);
        }
        sum += coefficient, square_sum += coefficient * coefficient;
      }
    }
    const double count = kFunctionCount * kMirrorCount, variance = square_sum / count - sum / count * sum / count;
    const double largest = wideBasis().spectrum[0] + 1.0;
    // the row is rounded to float, which turns it by up to u towards the largest component; the deviation is rounded too
    ASSERT_NEAR(double{data.deviation[k]} * data.deviation[k], variance,
                8 * kFloatRounding * std::sqrt(largest * variance) + 4 * kFloatRounding * variance)
        << "component " << k << " of class " << classOf(data, k);
  }
}

TEST(BasisFit, SortsASpectrumThatAddsUpToTheTotalVariance) {
  const Basis& basis = wideBasis();
  const std::vector<double> mean = mirroredMean();
  double total = 0.0;
  for (size_t i = 0; i < functions().size(); ++i) {
    const double residual = functions()[i] / 255.0 - mean[i % kSupportPointCount];
    total += residual * residual / kFunctionCount;  // the mean is mirror-symmetric: mirror images have the same energy
  }
  double sum = 0.0;
  for (int c = 0; c < kParityClassCount; ++c) {
    for (int i = 0; i < kOctantPointCount; ++i) {
      const double value = basis.spectrum[size_t(c) * kOctantPointCount + i];
      ASSERT_GE(value, 0.0);
      if (i > 0) {
        ASSERT_LE(value, basis.spectrum[size_t(c) * kOctantPointCount + i - 1]) << "class " << c << ", " << i;
      }
      sum += value;
    }
  }
  EXPECT_NEAR(sum, total, 1e-10 * total);
}

TEST(BasisFit, DoesNotDependOnTheOrderOfAdditions) {
  BasisFit fit;
  for (int n = kFunctionCount; n-- > 0;) fit.add(&functions()[size_t(n) * kSupportPointCount], 1);
  const Basis backwards = fit.fit(20), forwards = truncateBasis(wideBasis(), 20);
  ASSERT_EQ(backwards.data.class_count, forwards.data.class_count);
  for (size_t i = 0; i < forwards.spectrum.size(); ++i) {
    ASSERT_NEAR(backwards.spectrum[i], wideBasis().spectrum[i], 1e-10 * wideBasis().spectrum[0]) << "eigenvalue " << i;
  }
  for (size_t i = 0; i < forwards.data.mean.size(); ++i) ASSERT_NEAR(backwards.data.mean[i], forwards.data.mean[i], 2e-7) << i;
  // signs are fixed, so that the rows agree to float's precision where eigenvalues are apart
  for (int k = 0; k < 20; ++k) EXPECT_NEAR(dot(backwards.data, k, forwards.data, k), 1.0, 1e-5) << "component " << k;
}

// Three components, added with both signs in all eight combinations to a mean: each an amplitude at point p.
Basis fitOfThree(int mean, const std::function<int(int component, int p)>& amplitude) {
  std::vector<uint8_t> phi;
  for (int combination = 0; combination < 8; ++combination) {
    for (int p = 0; p < kSupportPointCount; ++p) {
      int value = mean;
      for (int k = 0; k < 3; ++k) value += (combination >> k & 1 ? -1 : 1) * amplitude(k, p);
      phi.push_back(static_cast<uint8_t>(value));
    }
  }
  BasisFit fit;
  fit.add(phi.data(), 8);
  return fit.fit(64);
}

TEST(BasisFit, RecoversAnExplicitSmallRankExactly) {
  // phi = 100 + 40 a s_0 + 20 b s_1 + 10 c s_6 with a, b, c in {-1, 1} in all eight combinations, s_k = a checkerboard of the
  // octant times the signs of parity class k: three components of known direction; variance (amplitude / 255)² * 8192
  const auto checker = [](int k, int i) { return (i >> k) & 1 ? -1 : 1; };
  const int classes[] = {0, 1, 6}, amplitude[] = {40, 20, 10};
  const BasisData data =
      fitOfThree(100, [&](int k, int p) {
        return amplitude[k] * checker(k, p % kOctantPointCount) * static_cast<int>(mirrorSign(classes[k], p / kOctantPointCount));
      }).data;
  ASSERT_EQ(data.coefficientCount(), 3);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(classOf(data, k), classes[k]);
    const double deviation = amplitude[k] / 255.0 * std::sqrt(8192.0);
    EXPECT_NEAR(data.deviation[k], deviation, 2 * kFloatRounding * deviation) << "component " << k;
    const float sign = data.components[size_t(k) * kOctantPointCount] > 0 ? 1.0f : -1.0f;
    for (int i = 0; i < kOctantPointCount; ++i) {
      ASSERT_NEAR(data.components[size_t(k) * kOctantPointCount + i], sign * checker(k, i) / 32.0, 1e-8)
          << "component " << k << ", " << i;
    }
  }
  for (int i = 0; i < kOctantPointCount; ++i) ASSERT_NEAR(data.mean[i], std::sqrt(8.0) * 100 / 255, 1e-6) << i;
}

TEST(BasisFit, HasNoEvenComponentOfOneLopsidedFunction) {
  // all of its variance is between its mirror images
  std::vector<uint8_t> one(kSupportPointCount);
  for (int p = 0; p < kSupportPointCount; ++p) one[p] = static_cast<uint8_t>(37 * p % 251);
  BasisFit fit;
  fit.add(one.data(), 1);
  const BasisData data = fit.fit(64).data;
  EXPECT_EQ(data.class_count[0], 0);
  EXPECT_EQ(data.coefficientCount(), kMirrorCount - 1);
}

// Many times the one function, once the other, both equal to all of their mirror images: the one direction is the difference, its variance
// that of one in count + 1.
void expectOneDirection(uint64_t count, int (*same)(int), int (*other)(int)) {
  std::vector<uint8_t> phi;
  for (uint64_t i = 0; i < (count + 1) * kSupportPointCount; ++i) {
    const auto p = static_cast<int>(i % kOctantPointCount);
    phi.push_back(static_cast<uint8_t>(i < count * kSupportPointCount ? same(p) : other(p)));
  }
  BasisFit fit;
  fit.add(phi.data(), count + 1);
  const Basis basis = fit.fit(16);
  ASSERT_EQ(basis.data.coefficientCount(), 1);
  EXPECT_EQ(classOf(basis.data, 0), 0);
  // in the octant the difference grows by sqrt(8), as it is even in all axes (docs/theory/math.md, section 2)
  double square = 0.0, product = 0.0;
  for (int i = 0; i < kOctantPointCount; ++i) {
    const double difference = (other(i) - same(i)) / 255.0 * std::sqrt(8.0);
    square += difference * difference;
    product += basis.data.components[i] * difference;
  }
  const double share = 1.0 / static_cast<double>(count + 1), variance = square * share * (1.0 - share);
  EXPECT_NEAR(*std::max_element(basis.spectrum.begin(), basis.spectrum.end()) / variance, 1.0, 1e-6);
  EXPECT_NEAR(std::fabs(product) / std::sqrt(square), 1.0, 1e-6);
}

TEST(BasisFit, FindsTheOneOtherFunctionAmongManyThatAreIdentical) {
  const auto ramp = [](int i) { return 37 * i % 256; };
  expectOneDirection(2000, ramp, [](int i) { return 37 * i % 256 ^ (i % 16 == 3 ? 64 : 0); });
  // the largest outlier that bytes allow
  expectOneDirection(
      63, [](int i) { return i % 2; }, [](int) { return 255; });
}

TEST(BasisFit, FindsDirectionsWhoseVariancesDifferTenMillionTimes) {
  // 100 steps at all points, 1 step at all points, 1 step at 8 points, in all combinations of signs
  const int classes[] = {0, 1, 6}, amplitude[] = {100, 1, 1}, points[] = {kSupportPointCount, kSupportPointCount, kMirrorCount};
  Basis basis = fitOfThree(128, [&](int k, int p) {
    if (k == 2 && p % kOctantPointCount != 77) return 0;
    return amplitude[k] * static_cast<int>(mirrorSign(classes[k], p / kOctantPointCount));
  });
  // no direction of rounding counts as a component
  EXPECT_EQ(basis.data.coefficientCount(), 3);
  std::sort(basis.spectrum.rbegin(), basis.spectrum.rend());
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(basis.spectrum[k] / (std::pow(amplitude[k] / 255.0, 2) * points[k]), 1.0, 1e-6) << k;
  EXPECT_LE(basis.spectrum[3], 1e-9 * basis.spectrum[0]);
}

TEST(TruncateBasis, KeepsTheComponentsOfLargestVariance) {
  const BasisData& wide = wideBasis().data;
  std::vector<float> deviations = wide.deviation;
  std::sort(deviations.rbegin(), deviations.rend());
  for (const int count : {1, 2, 17, 100, wide.coefficientCount(), 5000}) {
    const Basis narrow = truncateBasis(wideBasis(), count);
    const int kept = std::min(count, wide.coefficientCount());
    ASSERT_EQ(narrow.data.coefficientCount(), kept);
    ASSERT_EQ(std::accumulate(narrow.data.class_count.begin(), narrow.data.class_count.end(), 0), kept);
    ASSERT_EQ(narrow.data.components.size(), size_t(kept) * kOctantPointCount);
    std::vector<float> left = narrow.data.deviation;
    std::sort(left.rbegin(), left.rend());
    EXPECT_TRUE(std::equal(left.begin(), left.end(), deviations.begin())) << count;
    EXPECT_EQ(narrow.data.mean, wide.mean);
    EXPECT_EQ(narrow.spectrum, wideBasis().spectrum);
    // each row stands in the class that it came from
    for (int k = 0; k < kept; k += 13) {
      const auto row = narrow.data.components.begin() + size_t(k) * kOctantPointCount;
      int source = 0;
      while (!std::equal(row, row + kOctantPointCount, wide.components.begin() + size_t(source) * kOctantPointCount)) ++source;
      EXPECT_EQ(classOf(narrow.data, k), classOf(wide, source)) << "component " << k << " of " << count;
    }
  }
}

TEST(Whitened, LeavesTheChosenPowerOfEachDeviationAndAMeanSquareOfOne) {
  const BasisData basis = truncateBasis(wideBasis(), 40).data;
  for (const double whitening : {0.0, 0.5, 1.0}) {
    const BasisData used = whitened(basis, whitening);
    EXPECT_EQ(used.components, basis.components);
    double square_sum = 0.0;
    for (int k = 0; k < basis.coefficientCount(); ++k) {
      const double left = double{basis.deviation[k]} / used.deviation[k];  // the deviation of the coefficient that is used
      const double first = double{basis.deviation[0]} / used.deviation[0];
      EXPECT_NEAR(left / first, std::pow(double{basis.deviation[k]} / basis.deviation[0], 1.0 - whitening), 1e-5 * left / first)
          << "component " << k << ", whitening " << whitening;
      square_sum += left * left;
    }
    EXPECT_NEAR(square_sum / basis.coefficientCount(), 1.0, 1e-5) << "whitening " << whitening;
  }
}

TEST(KeptVariance, OfTheTrainingSetIsTheSpectrumsShare) {
  std::vector<double> spectrum = wideBasis().spectrum;
  std::sort(spectrum.rbegin(), spectrum.rend());
  const double total = std::accumulate(spectrum.begin(), spectrum.end(), 0.0);
  const std::vector<int> counts = {0, 1, 8, 64, 8192};
  const std::vector<double> kept = keptVariance(wideBasis(), functions().data(), kFunctionCount, counts);
  ASSERT_EQ(kept.size(), counts.size());
  for (size_t i = 0; i < counts.size(); ++i) {
    const double expected = std::accumulate(spectrum.begin(), spectrum.begin() + counts[i], 0.0) / total;
    // mean and rows in float: relative errors of a few u in each energy
    EXPECT_NEAR(kept[i], expected, 16 * kFloatRounding) << counts[i] << " components";
  }
  EXPECT_NEAR(kept.back(), 1.0, 1e-6) << "the training set lies in its own basis";
}

}  // namespace
}  // namespace nlg
