#include "runtime_eval/evaluator/generator.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "runtime_eval/simd/simd_target.h"

namespace nlg {

Generator::Generator(const GeneratorData& data)
    : representation_(data.representation),
      projection_(data.basis),
      theta0_(data.theta0),
      exact_last_layer_(data.exact_last_layer) {
  // the last layer yields theta itself
  std::vector<GeneratorLayer> layers = data.layers;
  GeneratorLayer& last = layers.back();
  for (int o = 0; o < last.output_count; ++o) {
    const float scale = data.output_scale[o];
    for (int i = 0; i < last.input_count; ++i) last.weight[size_t(o) * last.input_count + i] *= scale;
    last.bias[o] = data.theta0[o] + scale * last.bias[o];
  }
  layers_ = LayerStack(layers, data.slope);
}

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
  for (int begin = 0; begin < count; begin += kBatchCount) {
    const int batch = std::min(kBatchCount, count - begin);
    projection_.project(phi + size_t(begin) * kSupportPointCount, batch, scratch->layers_.input(), &scratch->projection_);
    layers_.run(batch, theta + size_t(begin) * representation_.thetaCount(), &scratch->layers_);
  }
}

void Generator::generate(const uint8_t* phi, int count, float* theta, GeneratorScratch* scratch) const {
  generateAll(phi, count, theta, scratch);
}

void Generator::generate(const float* phi, int count, float* theta, GeneratorScratch* scratch) const {
  generateAll(phi, count, theta, scratch);
}

GeneratorScratch::GeneratorScratch(const Generator& generator) : layers_(generator.layers_) {}

}  // namespace nlg
