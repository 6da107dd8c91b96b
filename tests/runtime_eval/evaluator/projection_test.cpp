#include "runtime_eval/evaluator/projection.h"

#include <gtest/gtest.h>

#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/sample_generator.h"

namespace nlg {
namespace {

// From the definition: class rows, mean, components, deviation, in double.
std::vector<double> projectNaively(const BasisData& basis, const std::vector<double>& phi, std::vector<double>* magnitude) {
  std::vector<double> coefficients;
  int row = 0;
  for (int c = 0; c < kParityClassCount; ++c) {
    for (int k = 0; k < basis.class_count[c]; ++k, ++row) {
      double sum = 0.0, absolute = 0.0;
      for (int i = 0; i < kOctantPointCount; ++i) {
        double value = 0.0, size = std::fabs(basis.mean[c * kOctantPointCount + i]);
        for (int m = 0; m < kMirrorCount; ++m) {
          value += mirrorSign(c, m) * phi[m * kOctantPointCount + i] / std::sqrt(8.0);
          size += phi[m * kOctantPointCount + i] / std::sqrt(8.0);
        }
        const double component = basis.components[size_t(row) * kOctantPointCount + i];
        sum += (value - basis.mean[c * kOctantPointCount + i]) * component;
        absolute += size * std::fabs(component);
      }
      coefficients.push_back(sum / basis.deviation[row]);
      magnitude->push_back(absolute / basis.deviation[row]);
    }
  }
  return coefficients;
}

TEST(Projection, EqualsTheDefinitionOnRaggedCountsAndEveryTarget) {
  const BasisData basis = sampleBasis(kSampleClasses, 7);
  const int K = basis.coefficientCount(), largest = kBatchCount;
  const std::vector<uint8_t> phi = sampleFunctions(largest);
  std::vector<std::vector<double>> expected, magnitude(largest);
  for (int n = 0; n < largest; ++n) {
    expected.push_back(projectNaively(basis, unquantised(&phi[size_t(n) * kSupportPointCount]), &magnitude[n]));
  }
  ProjectionScratch scratch;
  forEachTarget([&] {
    const Projection projection(basis);
    for (const int count : {0, 1, 2, 7, 8, 9, 31, 95, 96}) {
      std::vector<float> coefficients(size_t(largest) * K, 99.0f);
      projection.project(phi.data(), count, coefficients.data(), &scratch);
      for (int n = 0; n < largest; ++n) {
        for (int k = 0; k < K; ++k) {
          const float got = coefficients[size_t(n) * K + k];
          if (n >= count) {
            ASSERT_EQ(got, 99.0f) << "written behind " << count << " functions";
          } else {
            // 1024 fused multiply-adds, and the roundings of the packed row and of the bias
            ASSERT_NEAR(got, expected[n][k], (1024 + 4) * kFloatRounding * magnitude[n][k]) << n << " of " << count << ", " << k;
          }
        }
      }
    }
  });
}

TEST(Projection, GivesZeroForTheMean) {
  // a mean that bytes can hold: the same 102/255 in all octants, class 0 only
  BasisData basis = sampleBasis(kSampleClasses, 8);
  for (int i = 0; i < kOctantPointCount; ++i) basis.mean[i] = static_cast<float>(std::sqrt(8.0) * 102 / 255.0);
  const std::vector<uint8_t> phi(kSupportPointCount, 102);
  std::vector<double> magnitude;
  projectNaively(basis, unquantised(phi.data()), &magnitude);
  const Projection projection(basis);
  std::vector<float> coefficients(basis.coefficientCount());
  ProjectionScratch scratch;
  projection.project(phi.data(), 1, coefficients.data(), &scratch);
  for (int k = 0; k < basis.coefficientCount(); ++k) EXPECT_NEAR(coefficients[k], 0.0, 1028 * kFloatRounding * magnitude[k]) << k;
}

TEST(Projection, FlipsSignsForAMirroredFunction) {
  BasisData basis = sampleBasis(kSampleClasses, 9);
  const Projection projection(basis);
  const std::vector<uint8_t> phi = sampleFunctions(1);
  ProjectionScratch scratch;
  std::vector<float> plain(basis.coefficientCount()), mirrored(basis.coefficientCount());
  projection.project(phi.data(), 1, plain.data(), &scratch);
  for (int mirror = 0; mirror < kMirrorCount; ++mirror) {
    std::vector<uint8_t> image(kSupportPointCount);
    for (int p = 0; p < kSupportPointCount; ++p) image[p] = phi[p ^ (mirror * kOctantPointCount)];
    projection.project(image.data(), 1, mirrored.data(), &scratch);
    int k = 0;
    for (int c = 0; c < kParityClassCount; ++c) {
      // classes are whole numbers that only change sign, and so do all products: exactly, where there is no mean to subtract
      for (int n = 0; n < basis.class_count[c]; ++n, ++k) {
        ASSERT_EQ(mirrored[k], mirrorSign(c, mirror) * plain[k]) << "mirror " << mirror << ", class " << c << ", component " << k;
      }
    }
  }
}

TEST(Projection, IsTheIdentityOnCombinationsOfComponents) {
  // phi = 1/2 + sum of a_k component_k, unquantised: by orthonormal rows the naive projection returns a_k
  BasisData basis = sampleBasis({2, 2, 0, 0, 0, 0, 0, 1}, 10);
  std::fill(basis.mean.begin(), basis.mean.begin() + kOctantPointCount, static_cast<float>(0.5 * std::sqrt(8.0)));
  const std::vector<double> amplitudes = {0.3, -0.2, 0.25, 0.1, -0.4};
  const int classes[] = {0, 0, 1, 1, 7};
  std::vector<double> phi(kSupportPointCount, 0.5);
  for (int k = 0; k < 5; ++k) {
    for (int p = 0; p < kSupportPointCount; ++p) {
      phi[p] += amplitudes[k] * mirrorSign(classes[k], p / kOctantPointCount) *
                basis.components[k * kOctantPointCount + p % kOctantPointCount] / std::sqrt(8.0);
    }
  }
  std::vector<double> ignored;
  const std::vector<double> coefficients = projectNaively(basis, phi, &ignored);
  // the rows are orthonormal to float's precision
  for (int k = 0; k < 5; ++k) EXPECT_NEAR(coefficients[k] * basis.deviation[k], amplitudes[k], 1e-5) << k;
}

}  // namespace
}  // namespace nlg
