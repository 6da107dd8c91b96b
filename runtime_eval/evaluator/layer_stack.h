// Fully connected layers with LeakyReLU and skips, run on a batch: the layers of the generator.
//
// Hidden layer: h' = leaky(W h + b), plus h where input and output have the same width; the last layer is W h + b alone.
#pragma once

#include <vector>

#include "runtime_eval/evaluator/matrix_product.h"
#include "runtime_eval/evaluator/projection.h"

namespace nlg {

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

}  // namespace nlg
