#include "runtime_eval/evaluator/layer_stack.h"

#include <algorithm>
#include <utility>

namespace nlg {

LayerStack::LayerStack(const std::vector<GeneratorLayer>& layers, float slope, GeneratorPrecision precision)
    : precision_(precision), slope_(slope) {
  for (const GeneratorLayer& layer : layers) {
    widths_.push_back({layer.input_count, layer.output_count});
    if (precision == GeneratorPrecision::float32) {
      float_layers_.emplace_back(layer.weight.data(), layer.output_count, layer.input_count);
    } else {
      integer_layers_.emplace_back(layer.weight.data(), layer.output_count, layer.input_count, kActivationLimit);
    }
    biases_.emplace_back(layer.bias.begin(), layer.bias.end());
  }
}

void LayerStack::run(int batch, float* output, LayerScratch* scratch) const {
  float* current = scratch->activations_[0].data();
  float* next = scratch->activations_[1].data();
  for (size_t l = 0; l < widths_.size(); ++l) {
    const auto [inputs, outputs] = widths_[l];
    const bool last = l + 1 == widths_.size();
    const Epilogue epilogue = last ? Epilogue::none : inputs == outputs ? Epilogue::leaky_and_skip : Epilogue::leaky;
    float* result = last ? output : next;
    if (precision_ == GeneratorPrecision::float32) {
      multiply({current, inputs}, batch, float_layers_[l], biases_[l].data(), epilogue, slope_, result, outputs);
    } else {
      int16_t* integers = scratch->integers_.data();
      float* scales = scratch->scales_.data();
      const int stride = LayerScratch::integerStride(inputs);
      quantiseRows(current, batch, inputs, integers, stride, scales);
      multiply({integers, stride, scales}, batch, integer_layers_[l], biases_[l].data(), epilogue, slope_, current, result,
               outputs);
    }
    std::swap(current, next);
  }
}

LayerScratch::LayerScratch(const LayerStack& stack) {
  int width = 0;
  // the last layer's outputs go to the caller's memory
  for (const auto& [inputs, outputs] : stack.widths_) width = std::max(width, inputs);
  for (AlignedFloats& values : activations_) values.resize(size_t(kBatchCount) * width);
  if (stack.precision_ == GeneratorPrecision::int16) {
    integers_.resize(size_t(kBatchCount) * integerStride(width));
    scales_.resize(kBatchCount);
  }
}

}  // namespace nlg
