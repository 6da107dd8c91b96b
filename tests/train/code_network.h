// Networks of codes to test with, and what they say.
#pragma once

#include <torch/torch.h>

#include "tests/runtime_eval/sample_generator.h"
#include "tests/train/sample_set.h"
#include "train/generator/network/generator_network.h"

namespace nlg {

inline constexpr int kCodeCount = 16;

inline const BasisData& codeBasis() {
  static const BasisData basis = sampleBasis(kSampleClasses, 3);
  return basis;
}

inline GeneratorShape codeShape(int resolution) {
  GeneratorShape shape;
  shape.coefficient_count = codeBasis().coefficientCount();
  shape.width = 32;
  shape.layer_count = 3;
  shape.code_count = kCodeCount;
  shape.dictionary_resolution = resolution;
  return shape;
}

// Whose last layer does not stand at zero: every function has a code of its own.
inline GeneratorNetwork codeNetwork(int resolution, uint64_t seed) {
  GeneratorNetwork network(codeShape(resolution), Theta(kCodeCount, 0.0f), seed);
  const torch::NoGradGuard guard;
  torch::manual_seed(seed);
  network->lastLayer()->weight.normal_(0.0, 3.0);
  network->lastLayer()->bias.normal_(0.0, 20.0);
  return network;
}

// The logit of row `row` of some codes at a place, by the network's own dictionary, in double.
inline double logitAt(GeneratorNetwork& network, const torch::Tensor& codes, int64_t row, const LocalPoint& at) {
  const int r = network->shape().dictionary_resolution;
  const torch::Tensor nodes = network->dictionary().detach().contiguous(), z = codes.detach().contiguous();
  const auto K = z.size(1);
  double logit = 0.0;
  for (int n = 0; n < r * r * r; ++n) {
    const int node[3] = {n % r, n / r % r, n / (r * r)};
    double weight = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
      weight *= std::max(0.0, 1.0 - std::fabs((static_cast<double>(at[axis]) + 1.0) * 0.5 * (r - 1) - node[axis]));
    }
    if (weight == 0.0) continue;
    const float* of_node = nodes.data_ptr<float>() + n * (K + 1);
    double sum = of_node[K];
    for (int64_t k = 0; k < K; ++k) sum += double{z.data_ptr<float>()[row * K + k]} * of_node[k];
    logit += weight * sum;
  }
  return logit;
}

}  // namespace nlg
