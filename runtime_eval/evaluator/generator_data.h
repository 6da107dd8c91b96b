// The generator's numbers, shared by its file, its training and its kernels.
#pragma once

#include <vector>

#include "nlg/representation.h"
#include "runtime_eval/evaluator/layer_stack.h"
#include "runtime_eval/weights_file/weights_file.h"

namespace nlg {

// The version of the tensors' meaning, which the reader demands.
inline constexpr int kWeightsVersion = 1;

// The generator's numbers, unfolded. Hidden layer: h' = leaky(W h + b), plus h where input and output have the same width;
// last layer: theta = theta0 + output_scale * (W h + b).
struct GeneratorData {
  Representation representation;
  float slope = 0.01f;  // of the generator's own LeakyReLU
  BasisData basis;
  std::vector<GeneratorLayer> layers;  // the last one has D outputs
  std::vector<float> theta0;           // D
  std::vector<float> output_scale;     // D
  // Networks with a linear output: the generator was trained for a last layer that is solved for each function (fit/last_layer.h).
  bool exact_last_layer = false;
};

// Between file and numbers. The reader checks every shape, range and the support pattern; on failure *data is unspecified.
FileResult generatorFromWeights(const WeightsFile& file, GeneratorData* data);
WeightsFile weightsFromGenerator(const GeneratorData& data);

// theta of one function in double, straight from the formulas: what the vector code is tested against. phi: P, in [0, 1].
std::vector<double> generateReference(const GeneratorData& data, const double* phi);

}  // namespace nlg
