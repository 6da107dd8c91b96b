#include "nlg/generator.h"

#include <algorithm>
#include <cstdlib>
#include <utility>
#include <vector>

#include "nlg/simd.h"
#include "runtime_eval/evaluator/generator/generator_data.h"

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

struct Generator::Network {
  Representation representation;
  Projection projection;
  LayerStack layers;
  std::vector<float> theta0;
  bool exact_last_layer = false;
};

struct GeneratorScratch::Buffers {
  ProjectionScratch projection;
  LayerScratch layers;
};

Generator::Generator(const GeneratorData& data) {
  // the last layer yields theta itself
  std::vector<GeneratorLayer> layers = data.layers;
  GeneratorLayer& last = layers.back();
  for (int o = 0; o < last.output_count; ++o) {
    const float scale = data.output_scale[o];
    for (int i = 0; i < last.input_count; ++i) last.weight[size_t(o) * last.input_count + i] *= scale;
    last.bias[o] = data.theta0[o] + scale * last.bias[o];
  }
  network_ = std::make_shared<const Network>(
      Network{data.representation, Projection(data.basis), LayerStack(layers, data.slope), data.theta0, data.exact_last_layer});
}

const Representation& Generator::representation() const { return network_->representation; }
const float* Generator::theta0() const { return network_->theta0.data(); }
bool Generator::exactLastLayer() const { return network_->exact_last_layer; }

namespace {

FileResult obeyEnvironment() {
  const SimdStatus simd = forceSimdTargetFromEnvironment();
  if (simd == SimdStatus::ok) return {};
  return {FileStatus::simd_unavailable, "NLG_SIMD: " + simdRefusal(std::getenv("NLG_SIMD"), simd)};
}

FileResult prepare(FileResult result, const WeightsFile& file, Generator* generator) {
  GeneratorData data;
  if (result.ok()) result = generatorFromWeights(file, &data);
  if (result.ok()) *generator = Generator(data);
  return result;
}

}  // namespace

FileResult Generator::load(const std::string& path, Generator* generator) {
  WeightsFile file;
  FileResult result = obeyEnvironment();
  if (result.ok()) result = readWeightsFile(path, &file);
  return prepare(std::move(result), file, generator);
}

FileResult Generator::parse(std::string_view bytes, Generator* generator) {
  WeightsFile file;
  FileResult result = obeyEnvironment();
  if (result.ok()) result = parseWeights(bytes, &file);
  return prepare(std::move(result), file, generator);
}

template <class Sample>
void Generator::generateAll(const Sample* phi, int count, float* theta, GeneratorScratch* scratch) const {
  GeneratorScratch::Buffers& buffers = *scratch->buffers_;
  for (int begin = 0; begin < count; begin += kBatchCount) {
    const int batch = std::min(kBatchCount, count - begin);
    network_->projection.project(phi + size_t(begin) * kSupportPointCount, batch, buffers.layers.input(), &buffers.projection);
    network_->layers.run(batch, theta + size_t(begin) * network_->representation.thetaCount(), &buffers.layers);
  }
}

void Generator::generate(const uint8_t* phi, int count, float* theta, GeneratorScratch* scratch) const {
  generateAll(phi, count, theta, scratch);
}

void Generator::generate(const float* phi, int count, float* theta, GeneratorScratch* scratch) const {
  generateAll(phi, count, theta, scratch);
}

GeneratorScratch::GeneratorScratch(const Generator& generator)
    : buffers_(new Buffers{ProjectionScratch(), LayerScratch(generator.network_->layers)}) {}
GeneratorScratch::~GeneratorScratch() = default;
GeneratorScratch::GeneratorScratch(GeneratorScratch&&) noexcept = default;
GeneratorScratch& GeneratorScratch::operator=(GeneratorScratch&&) noexcept = default;

}  // namespace nlg
