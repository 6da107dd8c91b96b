#include "runtime_eval/evaluator/generator/projection.h"

#include <gtest/gtest.h>

#include <bit>

#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/sample_generator.h"

namespace nlg {
namespace {

// 255 times the classes, from the definition, in the order of phi.
std::vector<double> classesNaively(const std::vector<double>& phi) {
  std::vector<double> classes;
  for (int c = 0; c < kParityClassCount; ++c) {
    for (int i = 0; i < kOctantPointCount; ++i) {
      double sum = 0.0;
      for (int m = 0; m < kMirrorCount; ++m) {
        sum += (std::popcount(static_cast<unsigned>(c & m)) % 2 ? -255.0 : 255.0) * phi[m * kOctantPointCount + i];
      }
      classes.push_back(sum);
    }
  }
  return classes;
}

constexpr int kFunctions = 3;

TEST(ParityTransform, EqualsTheDefinitionOnEveryTarget) {
  const std::vector<uint8_t> phi = sampleFunctions(kFunctions).phi;
  forEachTarget([&] {
    std::vector<float> floats(size_t(kFunctions) * kClassStride);
    parityTransform(phi.data(), kFunctions, floats.data());
    for (int n = 0; n < kFunctions; ++n) {
      const std::vector<double> expected = classesNaively(unquantised(&phi[size_t(n) * kSupportPointCount]));
      for (int j = 0; j < kSupportPointCount; ++j) {
        // whole numbers up to 8 * 255: exact
        ASSERT_EQ(floats[size_t(n) * kClassStride + j], std::lround(expected[j]))
            << n << ", class " << j / 1024 << ", " << j % 1024;
      }
    }
  });
}

}  // namespace
}  // namespace nlg
