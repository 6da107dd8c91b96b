#include "runtime_eval/evaluator/generator.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "runtime_eval/simd/simd_target.h"

namespace nlg {

namespace {

// The last layer times the output scale, plus a constant.
void foldOutput(const std::vector<float>& scale, const std::vector<float>* constant, GeneratorLayer* layer) {
  for (int o = 0; o < layer->output_count; ++o) {
    for (int i = 0; i < layer->input_count; ++i) layer->weight[size_t(o) * layer->input_count + i] *= scale[o];
    layer->bias[o] = (constant != nullptr ? (*constant)[o] : 0.0f) + scale[o] * layer->bias[o];
  }
}

}  // namespace

Generator::Generator(const GeneratorData& data, GeneratorPrecision precision)
    : precision_(precision),
      representation_(data.representation),
      projection_(data.basis, precision),
      theta0_(data.theta0),
      output_scale_(data.output_scale),
      correction_step_count_(data.correction.step_count),
      correction_theta_unit_(data.correction.theta_unit),
      exact_last_layer_(data.correction.exact_last_layer) {
  // the last layers yield theta itself and its change
  std::vector<GeneratorLayer> layers = data.layers, correction = data.correction.layers;
  foldOutput(data.output_scale, &data.theta0, &layers.back());
  layers_ = LayerStack(layers, data.slope, precision);
  if (correction.empty()) return;
  foldOutput(data.output_scale, nullptr, &correction.back());
  correction_layers_ = LayerStack(correction, data.slope, GeneratorPrecision::float32);
}

namespace {

FileResult obeyEnvironment() {
  const SimdStatus simd = forceSimdTargetFromEnvironment();
  if (simd == SimdStatus::ok) return {};
  return {FileStatus::simd_unavailable, "NLG_SIMD: " + simdRefusal(std::getenv("NLG_SIMD"), simd)};
}

FileResult prepare(FileResult result, const WeightsFile& file, GeneratorPrecision precision, Generator* generator) {
  GeneratorData data;
  if (!result.ok()) return result;
  const FileResult made = generatorFromWeights(file, &data);
  if (!made.ok()) return made;
  *generator = Generator(data, precision);
  return result;
}

}  // namespace

FileResult Generator::load(const std::string& path, GeneratorPrecision precision, Generator* generator) {
  WeightsFile file;
  FileResult result = obeyEnvironment();
  if (result.ok()) result = readWeightsFile(path, &file);
  return prepare(std::move(result), file, precision, generator);
}

FileResult Generator::parse(std::string_view bytes, GeneratorPrecision precision, Generator* generator) {
  WeightsFile file;
  FileResult result = obeyEnvironment();
  if (result.ok()) result = parseWeights(bytes, &file);
  return prepare(std::move(result), file, precision, generator);
}

template <class Sample>
void Generator::generateAll(const Sample* phi, int count, float* theta, GeneratorScratch* scratch) const {
  for (int begin = 0; begin < count; begin += kBatchCount) {
    const int batch = std::min(kBatchCount, count - begin);
    projection_.project(phi + size_t(begin) * kSupportPointCount, batch, scratch->layers_.input(), &scratch->projection_);
    layers_.run(batch, theta + size_t(begin) * representation_.thetaCount(), &scratch->layers_);
  }
}

void Generator::writeThetaFeatures(const float* theta, float* features) const {
  for (size_t d = 0; d < theta0_.size(); ++d) {
    const float change = theta[d] - theta0_[d];
    features[d] = correction_theta_unit_ > 0.0f ? std::asinh(change / correction_theta_unit_) : change / output_scale_[d];
  }
}

void Generator::project(const uint8_t* phi, int count, float* coefficients, GeneratorScratch* scratch) const {
  projection_.project(phi, count, coefficients, &scratch->projection_);
}

void Generator::generateFromCoefficients(const float* coefficients, int count, float* theta, GeneratorScratch* scratch) const {
  std::copy_n(coefficients, size_t(count) * coefficientCount(), scratch->layers_.input());
  layers_.run(count, theta, &scratch->layers_);
}

void Generator::generate(const uint8_t* phi, int count, float* theta, GeneratorScratch* scratch) const {
  generateAll(phi, count, theta, scratch);
}

void Generator::generate(const float* phi, int count, float* theta, GeneratorScratch* scratch) const {
  generateAll(phi, count, theta, scratch);
}

GeneratorScratch::GeneratorScratch(const Generator& generator) : projection_(generator.precision_), layers_(generator.layers_) {}

}  // namespace nlg
