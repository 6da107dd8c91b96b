#include "runtime_eval/evaluator/generator.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "runtime_eval/support/simd_target.h"

namespace nlg {

Generator::Generator(const GeneratorData& data, GeneratorPrecision precision)
    : precision_(precision),
      representation_(data.representation),
      slope_(data.slope),
      projection_(data.basis, precision),
      theta0_(data.theta0) {
  for (size_t l = 0; l < data.layers.size(); ++l) {
    GeneratorLayer layer = data.layers[l];
    // the last layer yields theta itself: scale and constant part are folded into it
    if (l + 1 == data.layers.size()) {
      for (int o = 0; o < layer.output_count; ++o) {
        for (int i = 0; i < layer.input_count; ++i) layer.weight[size_t(o) * layer.input_count + i] *= data.output_scale[o];
        layer.bias[o] = data.theta0[o] + data.output_scale[o] * layer.bias[o];
      }
    }
    widths_.push_back({layer.input_count, layer.output_count});
    if (precision == GeneratorPrecision::float32) {
      float_layers_.emplace_back(layer.weight.data(), layer.output_count, layer.input_count);
    } else {
      integer_layers_.emplace_back(layer.weight.data(), layer.output_count, layer.input_count, kActivationLimit);
    }
    biases_.emplace_back(layer.bias.begin(), layer.bias.end());
  }
}

namespace {

WeightsResult obeyEnvironment() {
  const SimdStatus simd = forceSimdTargetFromEnvironment();
  if (simd == SimdStatus::ok) return {};
  return {WeightsStatus::simd_unavailable, "NLG_SIMD: " + simdRefusal(std::getenv("NLG_SIMD"), simd)};
}

WeightsResult prepare(WeightsResult result, const WeightsFile& file, GeneratorPrecision precision, Generator* generator) {
  GeneratorData data;
  if (result.ok()) result = generatorFromWeights(file, &data);
  if (result.ok()) *generator = Generator(data, precision);
  return result;
}

}  // namespace

WeightsResult Generator::load(const std::string& path, GeneratorPrecision precision, Generator* generator) {
  WeightsFile file;
  WeightsResult result = obeyEnvironment();
  if (result.ok()) result = readWeightsFile(path, &file);
  return prepare(std::move(result), file, precision, generator);
}

WeightsResult Generator::parse(std::string_view bytes, GeneratorPrecision precision, Generator* generator) {
  WeightsFile file;
  WeightsResult result = obeyEnvironment();
  if (result.ok()) result = parseWeights(bytes, &file);
  return prepare(std::move(result), file, precision, generator);
}

template <class Sample>
void Generator::generateAll(const Sample* phi, int count, float* theta, GeneratorScratch* scratch) const {
  for (int begin = 0; begin < count; begin += kBatchCount) {
    const int batch = std::min(kBatchCount, count - begin);
    projection_.project(phi + size_t(begin) * kSupportPointCount, batch, scratch->activations_[0].data(), &scratch->projection_);
    runLayers(batch, theta + size_t(begin) * representation_.thetaCount(), scratch);
  }
}

void Generator::runLayers(int batch, float* theta, GeneratorScratch* scratch) const {
  float* current = scratch->activations_[0].data();
  float* next = scratch->activations_[1].data();
  for (size_t l = 0; l < widths_.size(); ++l) {
    const auto [inputs, outputs] = widths_[l];
    const bool last = l + 1 == widths_.size();
    const Epilogue epilogue = last ? Epilogue::none : inputs == outputs ? Epilogue::leaky_and_skip : Epilogue::leaky;
    float* output = last ? theta : next;
    if (precision_ == GeneratorPrecision::float32) {
      multiply({current, inputs}, batch, float_layers_[l], biases_[l].data(), epilogue, slope_, output, outputs);
    } else {
      int16_t* integers = scratch->integers_.data();
      float* scales = scratch->scales_.data();
      const int stride = GeneratorScratch::integerStride(inputs);
      quantiseRows(current, batch, inputs, integers, stride, scales);
      multiply({integers, stride, scales}, batch, integer_layers_[l], biases_[l].data(), epilogue, slope_, current, output,
               outputs);
    }
    std::swap(current, next);
  }
}

void Generator::generate(const uint8_t* phi, int count, float* theta, GeneratorScratch* scratch) const {
  generateAll(phi, count, theta, scratch);
}

void Generator::generate(const float* phi, int count, float* theta, GeneratorScratch* scratch) const {
  generateAll(phi, count, theta, scratch);
}

GeneratorScratch::GeneratorScratch(const Generator& generator) : projection_(generator.precision_) {
  int width = generator.projection_.coefficientCount();
  // the last layer's outputs go to theta itself
  for (const auto& [inputs, outputs] : generator.widths_) width = std::max(width, inputs);
  for (AlignedFloats& values : activations_) values.resize(size_t(kBatchCount) * width);
  if (generator.precision_ == GeneratorPrecision::int16) {
    integers_.resize(size_t(kBatchCount) * integerStride(width));
    scales_.resize(kBatchCount);
  }
}

}  // namespace nlg
