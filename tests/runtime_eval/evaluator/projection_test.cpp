
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
  const SampleFunctions samples = sampleFunctions(largest);
  const std::vector<StoredFunction> functions = samples.views();
  std::vector<std::vector<double>> expected, magnitude(largest);
  for (int n = 0; n < largest; ++n) {
    expected.push_back(projectNaively(basis, unquantised(functions[n].phi), &magnitude[n]));
  }
  ProjectionScratch scratch;
  forEachTarget([&] {
    const Projection projection(basis);
    for (const int count : {0, 1, 2, 7, 8, 9, 31, 95, 96}) {
      std::vector<float> coefficients(size_t(largest) * K, 99.0f);
      projection.project(functions.data(), count, coefficients.data(), &scratch);
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

// Visibility without phi: what is seen has the tent, all else nothing. A diffused function of the same points differs only there.
TEST(Projection, ReadsVisibilityAsTheUndiffusedFunction) {
  const BasisData basis = sampleBasis(kSampleClasses, 8, GeneratorInput::samples);
  const Projection projection(basis);
  const StoredSample wall = wallSample(4);
  std::vector<uint8_t> seen(kSamplePointCount / 8, 0), valid = seen;
  for (int j = 0; j < kSamplePointCount; ++j) {
    if (wall.phi[supportPointOf(j)] > 0) seen[j / 8] |= 1 << j % 8;
    if (wall.valid(static_cast<int>(supportPointOf(j)))) valid[j / 8] |= 1 << j % 8;
  }
  ProjectionScratch scratch;
  std::vector<float> of_bits(basis.coefficientCount()), of_bytes(of_bits.size()), of_blind(of_bits.size());
  const VisibilitySamples samples{seen.data(), valid.data()};
  projection.project(&samples, 1, of_bits.data(), &scratch);
  const StoredFunction stored = wall.view();
  projection.project(&stored, 1, of_bytes.data(), &scratch);
  // phi is a byte, and so is its share of the tent
  for (size_t k = 0; k < of_bits.size(); ++k) EXPECT_NEAR(of_bits[k], of_bytes[k], 0.1) << k;
  // where all is dark, solid and dark are told apart
  std::vector<uint8_t> none(seen.size(), 0), all(seen.size(), 0xff);
  const VisibilitySamples solid{none.data(), none.data()}, dark{none.data(), all.data()};
  projection.project(&solid, 1, of_bits.data(), &scratch);
  projection.project(&dark, 1, of_blind.data(), &scratch);
  EXPECT_NE(of_bits, of_blind);
}

TEST(Projection, FlipsSignsForAMirroredFunction) {
  BasisData basis = sampleBasis(kSampleClasses, 9);
  const Projection projection(basis);
  const SampleFunctions samples = sampleFunctions(1);
  const std::vector<StoredFunction> functions = samples.views();
  ProjectionScratch scratch;
  std::vector<float> plain(basis.coefficientCount()), mirrored(basis.coefficientCount());
  projection.project(functions.data(), 1, plain.data(), &scratch);
  for (int mirror = 0; mirror < kMirrorCount; ++mirror) {
    std::vector<uint8_t> image(kSupportPointCount);
    for (int p = 0; p < kSupportPointCount; ++p) image[p] = samples.phi[p ^ (mirror * kOctantPointCount)];
    const StoredFunction mirror_image{image.data(), samples.validity.data()};
    projection.project(&mirror_image, 1, mirrored.data(), &scratch);
    int k = 0;
    for (int c = 0; c < kParityClassCount; ++c) {
      // classes are whole numbers that only change sign, and so do all products: exactly, where there is no mean to subtract
      for (int n = 0; n < basis.class_count[c]; ++n, ++k) {
        ASSERT_EQ(mirrored[k], mirrorSign(c, mirror) * plain[k]) << "mirror " << mirror << ", class " << c << ", component " << k;
      }
    }
  }
}

}  // namespace
}  // namespace nlg
