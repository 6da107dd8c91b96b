// A small generator of random numbers to test with.
#pragma once

#include "runtime_eval/evaluator/generator/generator_data.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {

// Orthonormal rows: within a class, component k is non-zero only at octant points i with i % class_count == k.
inline BasisData sampleBasis(const std::array<int, kParityClassCount>& class_count, uint64_t seed,
                             GeneratorInput input = GeneratorInput::coefficients) {
  Random random(seed);
  const bool reads_samples = input == GeneratorInput::samples;
  const int length = inputCount(input);
  BasisData basis{.input = input, .class_count = class_count};
  // only even functions have a mean over all mirror images; of samples there is none
  if (!reads_samples) {
    basis.mean.assign(size_t{kParityClassCount} * kOctantPointCount, 0.0f);
    for (int i = 0; i < kOctantPointCount; ++i) basis.mean[i] = static_cast<float>(random.uniform(0.0, 2.0));
  }
  for (const int count : class_count) {
    for (int k = 0; k < count; ++k) {
      std::vector<double> row(length, 0.0);
      double square = 0.0;
      for (int i = k; i < length; i += count) row[i] = random.normal(), square += row[i] * row[i];
      for (const double value : row) basis.components.push_back(static_cast<float>(value / std::sqrt(square)));
      const double deviation = random.uniform(0.2, 2.0);
      basis.deviation.push_back(reads_samples ? 1.0f : static_cast<float>(deviation));
    }
  }
  return basis;
}

// Class 4 is empty, as a class of a real basis may be.
inline constexpr std::array<int, kParityClassCount> kSampleClasses = {9, 5, 4, 3, 0, 2, 1, 1};

inline GeneratorData sampleGenerator(const Representation& representation, int width, int layer_count, uint64_t seed,
                                     GeneratorInput input = GeneratorInput::coefficients) {
  Random random(seed);
  GeneratorData data;
  data.representation = representation;
  data.slope = 0.05f;
  data.basis = sampleBasis(kSampleClasses, seed + 1, input);
  int inputs = data.basis.coefficientCount();
  for (int l = 0; l < layer_count; ++l) {
    GeneratorLayer layer{inputs, l + 1 == layer_count ? representation.thetaCount() : width, {}, {}};
    for (int i = 0; i < layer.output_count * layer.input_count; ++i) {
      layer.weight.push_back(static_cast<float>(random.normal() / std::sqrt(inputs)));
    }
    for (int o = 0; o < layer.output_count; ++o) layer.bias.push_back(static_cast<float>(0.1 * random.normal()));
    inputs = layer.output_count;
    data.layers.push_back(layer);
  }
  for (int i = 0; i < representation.thetaCount(); ++i) data.theta0.push_back(static_cast<float>(random.normal()));
  for (int i = 0; i < representation.thetaCount(); ++i)
    data.output_scale.push_back(static_cast<float>(random.uniform(0.05, 0.2)));
  return data;
}

// Stored functions one after another, every third of noise.
struct SampleFunctions {
  std::vector<uint8_t> phi, validity;
  std::vector<StoredFunction> views() const {
    std::vector<StoredFunction> functions;
    for (size_t n = 0; n < phi.size() / kSupportPointCount; ++n)
      functions.push_back({&phi[n * kSupportPointCount], &validity[n * kValidityByteCount]});
    return functions;
  }
};
inline SampleFunctions sampleFunctions(int count) {
  SampleFunctions functions;
  for (int n = 0; n < count; ++n) {
    const StoredSample sample = n % 3 == 2 ? noiseSample(n) : wallSample(n);
    functions.phi.insert(functions.phi.end(), sample.phi.begin(), sample.phi.end());
    functions.validity.insert(functions.validity.end(), sample.validity.begin(), sample.validity.end());
  }
  return functions;
}

inline std::vector<double> unquantised(const uint8_t* phi) {
  std::vector<double> values;
  for (int p = 0; p < kSupportPointCount; ++p) values.push_back(phi[p] / 255.0);
  return values;
}

}  // namespace nlg
