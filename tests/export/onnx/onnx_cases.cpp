// Writes what a runtime for ONNX must come to: onnx_cases FOLDER FUNCTION_COUNT [WEIGHTS ...].
//
// For small generators of random numbers and for every file of WEIGHTS: NAME.safetensors, and raw floats of the evaluator, one file a
// value of the model: NAME.phi.f32, NAME.theta.f32, NAME.coefficients.f32; of a generator of samples NAME.valid.f32, too.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/runtime_eval/sample_generator.h"

namespace nlg {
namespace {

void write(const std::string& path, const void* bytes, size_t count) {
  std::ofstream stream(path, std::ios::binary);
  stream.write(static_cast<const char*>(bytes), static_cast<std::streamsize>(count));
  if (!stream.flush()) std::exit(1);
}
void write(const std::string& path, const std::vector<float>& values) {
  write(path, values.data(), values.size() * sizeof(float));
}

// What the evaluator makes of the functions.
void writeCase(const std::string& stem, const std::string& bytes, int count) {
  WeightsFile file;
  GeneratorData data;
  FileResult result = parseWeights(bytes, &file);
  if (result.ok()) result = generatorFromWeights(file, &data);
  if (!result.ok()) {
    std::fprintf(stderr, "onnx_cases: %s: %s\n", stem.c_str(), result.detail.c_str());
    std::exit(1);
  }
  const SampleFunctions samples = sampleFunctions(count);
  const std::vector<StoredFunction> functions = samples.views();
  const Generator generator(data);
  GeneratorScratch scratch(generator);
  std::vector<float> theta(size_t(count) * data.representation.thetaCount());
  generator.generate(functions.data(), count, theta.data(), &scratch);
  const Projection projection(data.basis);
  ProjectionScratch projection_scratch;
  std::vector<float> phi, valid, coefficients(size_t(count) * data.basis.coefficientCount());
  const bool reads_samples = generator.readsSamples();
  for (int n = 0; n < count; ++n) {
    for (int i = 0; i < (reads_samples ? kSamplePointCount : kSupportPointCount); ++i) {
      const size_t p = reads_samples ? supportPointOf(i) : static_cast<size_t>(i);
      phi.push_back(static_cast<float>(functions[n].phi[p]) / 255.0f);
      valid.push_back(functions[n].isValid(p) ? 1.0f : 0.0f);
    }
    projection.project(&functions[n], 1, &coefficients[size_t(n) * data.basis.coefficientCount()], &projection_scratch);
  }
  write(stem + ".safetensors", bytes.data(), bytes.size());
  write(stem + ".phi.f32", phi);
  if (reads_samples) write(stem + ".valid.f32", valid);
  write(stem + ".theta.f32", theta);
  write(stem + ".coefficients.f32", coefficients);
}

std::string bytesOf(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void writeCases(const std::string& folder, int count, const std::vector<std::string>& weights) {
  // layers 25 → 25 → 25 → 113: a skip beside each hidden layer
  const GeneratorData skipping = sampleGenerator(Representation::tentMlp(), 25, 3, 1);
  writeCase(folder + "/skipping", serializeWeights(weightsFromGenerator(skipping)), count);
  const GeneratorData of_samples = sampleGenerator(Representation::tentMlp(), 24, 3, 4, GeneratorInput::samples);
  writeCase(folder + "/samples", serializeWeights(weightsFromGenerator(of_samples)), count);
  WeightsFile halves = weightsFromGenerator(sampleGenerator(Representation::productField(5), 24, 4, 2));
  for (const char* name : {"basis.components", "layer.0.weight", "layer.1.weight", "layer.3.weight"}) {
    if (!roundToFloat16(name, &halves.tensors[name]).ok()) std::exit(1);
  }
  writeCase(folder + "/float16", serializeWeights(halves), count);
  for (const std::string& path : weights) {
    writeCase(folder + "/" + std::filesystem::path(path).stem().string(), bytesOf(path), count);
  }
}

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  nlg::writeCases(argv[1], std::stoi(argv[2]), {argv + 3, argv + argc});
  return 0;
}
