// A small generator of random numbers to test with.
#pragma once

#include "runtime_eval/evaluator/generator/generator_data.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {

// Orthonormal rows: within a class, component k is non-zero only at octant points i with i % class_count == k.
inline BasisData sampleBasis(const std::array<int, kParityClassCount>& class_count, uint64_t seed) {
  Random random(seed);
  BasisData basis;
  basis.class_count = class_count;
  basis.mean.assign(size_t{kParityClassCount} * kOctantPointCount, 0.0f);
  // only even functions have a mean over all mirror images
  for (int i = 0; i < kOctantPointCount; ++i) basis.mean[i] = static_cast<float>(random.uniform(0.0, 2.0));
  for (const int count : class_count) {
    for (int k = 0; k < count; ++k) {
      std::vector<double> row(kOctantPointCount, 0.0);
      double length = 0.0;
      for (int i = k; i < kOctantPointCount; i += count) row[i] = random.normal(), length += row[i] * row[i];
      for (const double value : row) basis.components.push_back(static_cast<float>(value / std::sqrt(length)));
      basis.deviation.push_back(static_cast<float>(random.uniform(0.2, 2.0)));
    }
  }
  return basis;
}

// Class 4 is empty, as a class of a real basis may be.
inline constexpr std::array<int, kParityClassCount> kSampleClasses = {9, 5, 4, 3, 0, 2, 1, 1};

inline GeneratorData sampleGenerator(const Representation& representation, int width, int layer_count, uint64_t seed) {
  Random random(seed);
  GeneratorData data;
  data.representation = representation;
  data.slope = 0.05f;
  data.basis = sampleBasis(kSampleClasses, seed + 1);
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
inline std::vector<uint8_t> sampleFunctions(int count) {
  std::vector<uint8_t> phi;
  for (int n = 0; n < count; ++n) {
    const StoredSample sample = n % 3 == 2 ? noiseSample(n) : wallSample(n);
    phi.insert(phi.end(), sample.phi.begin(), sample.phi.end());
  }
  return phi;
}

inline std::vector<double> unquantised(const uint8_t* phi) {
  std::vector<double> values;
  for (int p = 0; p < kSupportPointCount; ++p) values.push_back(phi[p] / 255.0);
  return values;
}

}  // namespace nlg
