// The generator's numbers, shared by its file, its training and its kernels.
#pragma once

#include <vector>

#include "nlg/representation.h"
#include "runtime_eval/evaluator/generator/matrix_product.h"
#include "runtime_eval/evaluator/generator/projection.h"
#include "runtime_eval/weights_file/weights_file.h"

namespace nlg {

// Fully connected layers with LeakyReLU and skips, run on a batch: the layers of the generator.
//
// Hidden layer: h' = leaky(W h + b), plus h where input and output have the same width; the last layer is W h + b alone.

// One layer as the file holds it.
struct GeneratorLayer {
  int input_count = 0, output_count = 0;
  std::vector<float> weight;  // outputs x inputs
  std::vector<float> bias;    // outputs
};

class LayerScratch;

class LayerStack {
 public:
  LayerStack() = default;
  // slope   of LeakyReLU, in (0, 1)
  LayerStack(const std::vector<GeneratorLayer>& layers, float slope);

  // Runs on what the caller wrote to scratch->input(), one row a function. A row's result does not depend on the others.
  // batch    at most kBatchCount
  // output   one row a function
  void run(int batch, float* output, LayerScratch* scratch) const;

 private:
  friend class LayerScratch;
  struct Layer {
    int input_count, output_count;
    PackedMatrix matrix;
    AlignedFloats bias;
  };

  float slope_ = 0.01f;
  std::vector<Layer> layers_;
};

// Working memory of one thread, for one stack.
class LayerScratch {
 public:
  explicit LayerScratch(const LayerStack& stack);
  float* input() { return activations_[0].data(); }

 private:
  friend class LayerStack;
  AlignedFloats activations_[2];
};

// The newest version of the tensors' meaning. Generators of samples are of version 2, all others of 1, which older readers take, too.
inline constexpr int kWeightsVersion = 2;

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

// theta of one function in double, straight from the formulas: what the vector code is tested against.
std::vector<double> generateReference(const GeneratorData& data, const StoredFunction& function);

}  // namespace nlg
