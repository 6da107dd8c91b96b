#include "runtime_eval/evaluator/layer_stack.h"

#include <algorithm>
#include <utility>

namespace nlg {

LayerStack::LayerStack(const std::vector<GeneratorLayer>& layers, float slope) : slope_(slope) {
  for (const GeneratorLayer& layer : layers) {
    layers_.push_back({layer.input_count, layer.output_count,
                       PackedMatrix(layer.weight.data(), layer.output_count, layer.input_count),
                       AlignedFloats(layer.bias.begin(), layer.bias.end())});
  }
}

void LayerStack::run(int batch, float* output, LayerScratch* scratch) const {
  float* current = scratch->activations_[0].data();
  float* next = scratch->activations_[1].data();
  for (const Layer& layer : layers_) {
    const bool last = &layer == &layers_.back();
    const Epilogue epilogue = last                                      ? Epilogue::none
                              : layer.input_count == layer.output_count ? Epilogue::leaky_and_skip
                                                                        : Epilogue::leaky;
    multiply({current, layer.input_count}, batch, layer.matrix, layer.bias.data(), epilogue, slope_, last ? output : next,
             layer.output_count);
    std::swap(current, next);
  }
}

LayerScratch::LayerScratch(const LayerStack& stack) {
  int width = 0;
  // the last layer's outputs go to the caller's memory
  for (const LayerStack::Layer& layer : stack.layers_) width = std::max(width, layer.input_count);
  for (AlignedFloats& values : activations_) values.resize(size_t(kBatchCount) * width);
}

}  // namespace nlg
