// Fully connected layers with LeakyReLU and skips, run on a batch: what the generator and its correction steps are made of.
//
// Hidden layer: h' = leaky(W h + b), plus h where input and output have the same width; the last layer is W h + b alone.
#pragma once

#include <vector>

#include "runtime_eval/evaluator/integer_product.h"
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
  LayerStack(const std::vector<GeneratorLayer>& layers, float slope, GeneratorPrecision precision);

  bool empty() const { return widths_.empty(); }
  int inputCount() const { return widths_.front().inputs; }
  int outputCount() const { return widths_.back().outputs; }

  // Runs on what the caller wrote to scratch->input(), batch x inputCount(). A row's result does not depend on the others.
  // batch    at most kBatchCount
  // output   batch x outputCount()
  void run(int batch, float* output, LayerScratch* scratch) const;

 private:
  friend class LayerScratch;
  struct Width {
    int inputs, outputs;
  };

  GeneratorPrecision precision_ = GeneratorPrecision::float32;
  float slope_ = 0.01f;
  std::vector<Width> widths_;  // of the layers
  std::vector<PackedMatrix> float_layers_;
  std::vector<PackedIntegerMatrix> integer_layers_;
  std::vector<AlignedFloats> biases_;
};

// Working memory of one thread, for one stack.
class LayerScratch {
 public:
  explicit LayerScratch(const LayerStack& stack);
  float* input() { return activations_[0].data(); }

 private:
  friend class LayerStack;
  // rows of integers begin at cache lines, and not all in the same set of the first-level cache
  static int integerStride(int width) { return (width + 31) / 32 * 32 + 32; }

  AlignedFloats activations_[2];
  AlignedIntegers integers_;
  AlignedFloats scales_;
};

}  // namespace nlg
