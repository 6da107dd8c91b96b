// A generator of the real one's size to measure with: K = 512, 6 layers of 512, the numbers random.
#pragma once

#include <cmath>

#include "nlg/generator.h"
#include "runtime_eval/evaluator/generator/generator_data.h"
#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {

inline constexpr int kBenchmarkWidth = 512, kBenchmarkLayerCount = 6;
// multiply-adds of one function, the transform aside
inline constexpr double kBenchmarkProducts = double{kBenchmarkWidth} * kOctantPointCount +
                                             (kBenchmarkLayerCount - 1.0) * kBenchmarkWidth * kBenchmarkWidth +
                                             double{kBenchmarkWidth} * ThetaLayout::count;

inline std::vector<float> normalValues(size_t count, double deviation, Random& random) {
  std::vector<float> values(count);
  for (float& value : values) value = static_cast<float>(deviation * random.normal());
  return values;
}

inline GeneratorData randomGenerator() {
  Random random(1);
  GeneratorData data;
  data.basis.class_count = {126, 82, 81, 42, 81, 42, 42, 16};  // as real bases fall out
  data.basis.mean = normalValues(kSupportPointCount, 0.1, random);
  data.basis.components = normalValues(size_t{kBenchmarkWidth} * kOctantPointCount, 1.0 / 32, random);
  data.basis.deviation.assign(kBenchmarkWidth, 1.0f);
  for (int l = 0; l < kBenchmarkLayerCount; ++l) {
    const int outputs = l + 1 == kBenchmarkLayerCount ? ThetaLayout::count : kBenchmarkWidth;
    data.layers.push_back({kBenchmarkWidth, outputs,
                           normalValues(size_t{kBenchmarkWidth} * outputs, 1.0 / std::sqrt(kBenchmarkWidth), random),
                           normalValues(outputs, 0.1, random)});
  }
  data.theta0.assign(ThetaLayout::count, 0.0f);
  data.output_scale.assign(ThetaLayout::count, 1.0f);
  return data;
}

inline std::vector<uint8_t> randomBytes(size_t count) {
  std::vector<uint8_t> bytes(count);
  Random random(2);
  for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random.next() >> 24);
  return bytes;
}

// Functions of these samples, one after another, valid everywhere.
inline std::vector<StoredFunction> validFunctions(const std::vector<uint8_t>& phi) {
  static const std::vector<uint8_t> validity(kValidityByteCount, 0xff);
  std::vector<StoredFunction> functions;
  for (size_t first = 0; first < phi.size(); first += kSupportPointCount) functions.push_back({&phi[first], validity.data()});
  return functions;
}

}  // namespace nlg
