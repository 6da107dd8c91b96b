// The generator network in libtorch: coefficients, or samples, → theta.
#pragma once

#include <torch/nn.h>

#include <vector>

#include "runtime_eval/evaluator/generator/generator_data.h"
#include "runtime_eval/fit/fit_result.h"

namespace nlg {

struct GeneratorShape {
  GeneratorInput input = GeneratorInput::coefficients;
  int coefficient_count = 512;  // of samples a multiple of 8: as many components in each parity class
  int width = 512;
  int layer_count = 6;            // the last one yields theta
  double slope = 0.01;            // LeakyReLU
  double output_scale = 0.05;     // theta = theta0 + output_scale * last layer: keeps Adam's first steps small in theta
  bool exact_last_layer = true;   // networks with a linear output: the last layer is solved after the generator
  int code_count = 0;             // K of codes, whose dictionary is trained with the generator; 0: theta is no code
  int dictionary_resolution = 9;  // of codes: nodes along an axis
};

// The shape of a generator that exists. output_scale stays as `shape` has it: takeNumbers folds the generator's own into the last layer.
GeneratorShape shapeOf(const GeneratorData& data, GeneratorShape shape);

// The formulas of GeneratorData (runtime_eval/evaluator/generator/generator_data.h), differentiable. The last layer starts at zero: the
// untrained network yields theta0 for every function.
class GeneratorNetworkImpl : public torch::nn::Module {
 public:
  GeneratorNetworkImpl(const GeneratorShape& shape, const Theta& theta0, uint64_t seed);

  // input   B x TrainingData::inputCount(): coefficients, or parity classes of samples
  // returns B x D
  torch::Tensor forward(torch::Tensor input);

  const GeneratorShape& shape() const { return shape_; }
  bool solvesLastLayer(const Representation& representation) const {
    return shape_.exact_last_layer && representation.hasLinearOutput();
  }

  // Codes: c and b_k at some points, count x (K + 1), c last; differentiable.
  torch::Tensor dictionaryAt(const PointSet& points, int first, int count);
  // r³ x (K + 1), c last; the nodes x fastest.
  torch::Tensor& dictionary() { return dictionary_; }
  // K, in the unit of codes: what a fit's prior knows of them.
  torch::Tensor& deviations() { return deviations_; }
  torch::nn::Linear& lastLayer() { return layers_.back(); }

  // Of the learning rate, by the place of a parameter among parameters().
  double rateFactor(size_t parameter) const;

  // Its present numbers for the evaluator. Of codes, the dictionary is rounded to what a file holds.
  // basis   of coefficients; of samples the network's own components take its place
  GeneratorData toData(const Representation& representation, const BasisData& basis) const;
  // The other way: a generator of this very shape goes on being trained. Its basis and representation are for the caller.
  void takeNumbers(const GeneratorData& data);

 private:
  GeneratorShape shape_;
  std::vector<torch::nn::Linear> layers_;
  torch::Tensor components_;  // of samples: 8 x K / 8 x 384, by parity class
  torch::Tensor theta0_, dictionary_, deviations_;
  size_t dictionary_parameter_ = 0;  // its place among parameters()
};
TORCH_MODULE(GeneratorNetwork);

}  // namespace nlg
