#include "nlg/generator.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include "nlg/simd.h"
#include "runtime_eval/evaluator/generator/generator_data.h"

namespace nlg {
namespace {

// What components weigh at the points of mirror m, of a class's numbers i (docs/theory/math.md §2, §6).
double inputReference(GeneratorInput input, const StoredFunction& function, int m, int i) {
  if (input == GeneratorInput::coefficients) return function.phi[m * kOctantPointCount + i] / 255.0;
  const size_t point = supportPointOf(m * kOctantSampleCount + i % kOctantSampleCount);
  const double phi = function.phi[point] / 255.0, valid = function.isValid(point) ? 1.0 : 0.0;
  if (i < kOctantSampleCount) return phi;
  if (i >= 2 * kOctantSampleCount) return 0.3 * (valid - 0.9);
  return 0.3 * (std::min(1.0, phi / std::max(double{kLeastTent}, double{tent(supportPattern().points[point])})) - 0.7) * valid;
}

std::vector<double> coefficientsReference(const BasisData& basis, const StoredFunction& function) {
  const int length = inputCount(basis.input);
  std::vector<double> coefficients;
  for (int c = 0; c < kParityClassCount; ++c) {
    std::vector<double> parity(length, 0.0);
    for (int m = 0; m < kMirrorCount; ++m) {
      for (int i = 0; i < length; ++i)
        parity[i] += mirrorSign(c, m) * inputReference(basis.input, function, m, i) / std::sqrt(8.0);
    }
    // standardised coefficients of the class (docs/theory/math.md §3)
    for (int k = 0; k < basis.class_count[c]; ++k) {
      const size_t row = coefficients.size();
      double sum = 0.0;
      for (int i = 0; i < length; ++i) {
        const double mean = basis.mean.empty() ? 0.0 : basis.mean[c * length + i];
        sum += (parity[i] - mean) * basis.components[row * length + i];
      }
      coefficients.push_back(sum / basis.deviation[row]);
    }
  }
  return coefficients;
}

std::vector<double> runLayersReference(const std::vector<GeneratorLayer>& layers, double slope, std::vector<double> values) {
  for (size_t l = 0; l < layers.size(); ++l) {
    const GeneratorLayer& layer = layers[l];
    std::vector<double> outputs(layer.output_count);
    for (int o = 0; o < layer.output_count; ++o) {
      double sum = layer.bias[o];
      for (int i = 0; i < layer.input_count; ++i)
        sum += static_cast<double>(layer.weight[size_t(o) * layer.input_count + i]) * values[i];
      if (l + 1 == layers.size()) {
        outputs[o] = sum;
      } else {
        outputs[o] = sum > 0 ? sum : slope * sum;
        if (layer.input_count == layer.output_count) outputs[o] += values[o];
      }
    }
    values = std::move(outputs);
  }
  return values;
}

}  // namespace

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
bool Generator::readsSamples() const { return network_->projection.input() == GeneratorInput::samples; }

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

template <class Function>
void Generator::generateAll(const Function* functions, int count, float* theta, GeneratorScratch* scratch) const {
  GeneratorScratch::Buffers& buffers = *scratch->buffers_;
  for (int begin = 0; begin < count; begin += kBatchCount) {
    const int batch = std::min(kBatchCount, count - begin);
    network_->projection.project(functions + begin, batch, buffers.layers.input(), &buffers.projection);
    network_->layers.run(batch, theta + size_t(begin) * network_->representation.thetaCount(), &buffers.layers);
  }
}

void Generator::generate(const StoredFunction* functions, int count, float* theta, GeneratorScratch* scratch) const {
  generateAll(functions, count, theta, scratch);
}

void Generator::generate(const VisibilitySamples* functions, int count, float* theta, GeneratorScratch* scratch) const {
  generateAll(functions, count, theta, scratch);
}

GeneratorScratch::GeneratorScratch(const Generator& generator)
    : buffers_(new Buffers{ProjectionScratch(), LayerScratch(generator.network_->layers)}) {}
GeneratorScratch::~GeneratorScratch() = default;
GeneratorScratch::GeneratorScratch(GeneratorScratch&&) noexcept = default;
GeneratorScratch& GeneratorScratch::operator=(GeneratorScratch&&) noexcept = default;

std::vector<double> generateReference(const GeneratorData& data, const StoredFunction& function) {
  std::vector<double> theta = runLayersReference(data.layers, data.slope, coefficientsReference(data.basis, function));
  for (size_t i = 0; i < theta.size(); ++i) theta[i] = data.theta0[i] + data.output_scale[i] * theta[i];
  return theta;
}

}  // namespace nlg
