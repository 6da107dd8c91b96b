// The inputs that weights_fuzz starts from: headers of the smallest generators in both forms that the target
// completes, and small files that are whole. Their numbers do not matter; names, shapes and texts do.
#include <cstring>
#include <string>

#include "nlg/generator.h"
#include "runtime_eval/evaluator/dictionary.h"
#include "runtime_eval/evaluator/generator/generator_data.h"
#include "tests/fuzz/fuzz.h"

namespace nlg::fuzz {
namespace {

std::vector<GeneratorLayer> smallLayers(int input_count, int output_count, int layer_count, int width) {
  std::vector<GeneratorLayer> layers;
  for (int l = 0; l < layer_count; ++l) {
    const int inputs = l == 0 ? input_count : width, outputs = l + 1 == layer_count ? output_count : width;
    layers.push_back({inputs, outputs, std::vector<float>(size_t(inputs) * outputs), std::vector<float>(outputs)});
  }
  return layers;
}

// The smallest of a code: nodes of 0.
SharedDictionary smallDictionary(int code_count) {
  const auto K = static_cast<size_t>(code_count);
  return std::make_shared<const Dictionary>(
      DictionaryData{3, code_count, std::vector<int8_t>((K + 1) * 27), std::vector<int8_t>(K + 1), std::vector<float>(K, 1.0f)});
}

GeneratorData smallGenerator(const char* representation, int component_count, int layer_count, int width) {
  GeneratorData data;
  findRepresentation(representation, &data.representation);
  if (data.representation.isCode()) data.representation = Representation::code(smallDictionary(data.representation.code_count));
  // every class has its turn, so that one of them may be empty
  for (int k = 0; k < component_count; ++k) ++data.basis.class_count[k % kParityClassCount];
  data.basis.mean.resize(size_t{kParityClassCount} * kOctantPointCount);
  data.basis.components.resize(size_t(component_count) * kOctantPointCount);
  data.basis.deviation.resize(component_count, 1.0f);
  const int theta_count = data.representation.thetaCount();
  data.layers = smallLayers(component_count, theta_count, layer_count, width);
  data.theta0.resize(theta_count);
  data.output_scale.resize(theta_count, 1.0f);
  return data;
}

// The file of a generator with all its tensors in float16.
WeightsFile inFloat16(const GeneratorData& data) {
  WeightsFile file = weightsFromGenerator(data);
  for (auto& [name, tensor] : file.tensors) roundToFloat16(name, &tensor);
  return file;
}

std::string headerOf(const std::string& bytes) {
  uint64_t length = 0;
  std::memcpy(&length, bytes.data(), sizeof length);
  const std::string padded = bytes.substr(sizeof length, length);
  return padded.substr(0, padded.rfind('}') + 1);
}

WeightsFile smallFile() {
  WeightsFile file;
  file.tensors["empty"] = {{0, 5}, {}};
  file.tensors["layer"] = {{2, 2}, {0.0f, -1.0f, 2.5f, 1e-20f}};
  file.tensors["half"] = {{2}, {1.0f, -0.5f}, WeightsDtype::float16};
  file.tensors["scalar"] = {{}, {0.01f}};
  file.metadata = {{"note", "quote \" back\\slash\n\x01 é 𝄞"}, {"", "empty key"}};
  return file;
}

}  // namespace

Seeds seeds() {
  Seeds seeds = {{"whole", serializeWeights(smallFile())}, {"whole_empty", serializeWeights({})}};
  struct Size {
    int component_count, layer_count, width;
  };
  for (const Size& size : {Size{1, 1, 1}, Size{2, 2, 1}, Size{3, 3, 3}, Size{9, 4, 2}}) {
    for (const char* representation : kRepresentationNames) {
      const GeneratorData data = smallGenerator(representation, size.component_count, size.layer_count, size.width);
      const std::string header = headerOf(serializeWeights(weightsFromGenerator(data)));
      const std::string name = representation + ("_" + std::to_string(size.layer_count));
      const std::string half = headerOf(serializeWeights(inFloat16(data)));
      seeds.insert(seeds.end(), {{name + "_half_header", half},
                                 {name + "_half_shapes", "[" + half},
                                 {name + "_header", header},
                                 {name + "_shapes", "[" + header},
                                 // behind a zero byte: how much longer the data is than the header says, and what fills it
                                 {name + "_long", header + std::string("\0\4", 2)},
                                 {name + "_short", header + std::string("\0\xfc", 2)},
                                 {name + "_filled", header + std::string("\0\0", 2) + "\x33\x33\xb3\x3e"}});
    }
  }
  return seeds;
}

}  // namespace nlg::fuzz
