#include "nlg/generator.h"

#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <locale>
#include <sstream>

#include "runtime_eval/evaluator/dictionary.h"
#include "runtime_eval/evaluator/generator/generator_data.h"
#include "runtime_eval/weights_file/header_parser.h"

namespace nlg {
namespace {

constexpr int kLargestWidth = 8192;
constexpr int kLargestLayerCount = 32;
constexpr const char* kSamples = "samples";

std::string hexadecimal(uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016" PRIx64, value);
  return text;
}

std::string shapeText(const std::vector<uint64_t>& shape) {
  std::string text;
  for (const uint64_t extent : shape) {
    if (!text.empty()) text += " x ";
    text += std::to_string(extent);
  }
  return text;
}

// The file's own text in a message: one line, and no longer than a line.
std::string shown(const std::string& text) { return jsonQuoted(text.substr(0, 40)); }

// Reads what a generator needs from a file and remembers the first thing that was wrong.
class TensorReader {
 public:
  explicit TensorReader(const WeightsFile& file) : file_(file) {}

  bool ok() const { return result_.ok(); }
  const FileResult& result() const { return result_; }

  void fail(FileStatus status, const std::string& detail) {
    if (ok()) result_ = {status, detail};
  }

  std::vector<float> tensor(const std::string& name, const std::vector<uint64_t>& shape) {
    const auto found = file_.tensors.find(name);
    if (found == file_.tensors.end()) {
      fail(FileStatus::tensor_missing, "no tensor " + name);
    } else if (found->second.shape != shape) {
      fail(FileStatus::tensor_unexpected,
           name + ": expected shape " + shapeText(shape) + ", got " + shapeText(found->second.shape));
    } else if (!std::all_of(found->second.values.begin(), found->second.values.end(), [](float v) { return std::isfinite(v); })) {
      fail(FileStatus::value_not_finite, name + ": a value is not finite");
    } else {
      return found->second.values;
    }
    return {};
  }

  std::string text(const std::string& key) {
    const auto found = file_.metadata.find(key);
    if (found != file_.metadata.end()) return found->second;
    fail(FileStatus::tensor_missing, "no metadata key " + key);
    return {};
  }

  double number(const std::string& key, double low, double high) {
    const std::string value = text(key);
    // strtod would read numbers as the engine's locale writes them, and end at a zero byte
    std::istringstream stream(value);
    stream.imbue(std::locale::classic());
    double parsed = 0.0;
    const bool is_number = static_cast<bool>(stream >> std::noskipws >> parsed) && stream.peek() == EOF;
    if (!is_number || !(parsed >= low && parsed <= high)) {
      fail(FileStatus::value_out_of_range, "metadata " + key + ": expected a number from " + std::to_string(low) + " to " +
                                               std::to_string(high) + ", got " + shown(value));
      return low;
    }
    return parsed;
  }

  int integer(const std::string& key, int low, int high) {
    const double value = number(key, low, high);
    if (value != std::floor(value)) fail(FileStatus::value_out_of_range, "metadata " + key + ": expected an integer");
    return static_cast<int>(value);
  }

 private:
  const WeightsFile& file_;
  FileResult result_;
};

void readBasis(TensorReader& reader, BasisData* basis) {
  int coefficient_count = 0;
  for (int c = 0; c < kParityClassCount; ++c) {
    basis->class_count[c] = reader.integer("class_count." + std::to_string(c), 0, kOctantPointCount);
    coefficient_count += basis->class_count[c];
  }
  if (coefficient_count == 0) reader.fail(FileStatus::value_out_of_range, "the basis has no component");
  const uint64_t length = static_cast<uint64_t>(inputCount(basis->input)), count = static_cast<uint64_t>(coefficient_count);
  basis->components = reader.tensor("basis.components", {count, length});
  if (basis->input == GeneratorInput::samples) {
    basis->deviation.assign(count, 1.0f);
    return;
  }
  basis->mean = reader.tensor("basis.mean", {uint64_t{kParityClassCount}, length});
  basis->deviation = reader.tensor("basis.deviation", {count});
  for (const float deviation : basis->deviation) {
    // its inverse is folded into the components: far below any real deviation that would no longer be finite
    if (!(deviation >= 1e-30f)) reader.fail(FileStatus::value_out_of_range, "basis.deviation: expected values from 1e-30 on");
  }
}

// output_count   of the last layer
std::vector<GeneratorLayer> readLayers(TensorReader& reader, int input_count, int output_count) {
  const int layer_count = reader.integer("layer_count", 1, kLargestLayerCount);
  const int width = reader.integer("width", 1, kLargestWidth);
  std::vector<GeneratorLayer> layers;
  for (int l = 0; l < layer_count && reader.ok(); ++l) {
    GeneratorLayer layer;
    layer.input_count = input_count;
    layer.output_count = l + 1 == layer_count ? output_count : width;
    const std::string name = "layer." + std::to_string(l);
    const uint64_t outputs = static_cast<uint64_t>(layer.output_count), inputs = static_cast<uint64_t>(layer.input_count);
    layer.weight = reader.tensor(name + ".weight", {outputs, inputs});
    layer.bias = reader.tensor(name + ".bias", {outputs});
    input_count = layer.output_count;
    layers.push_back(std::move(layer));
  }
  return layers;
}

// Whole numbers that a byte holds.
std::vector<int8_t> readBytes(TensorReader& reader, const std::string& name, const std::vector<uint64_t>& shape) {
  std::vector<int8_t> bytes;
  for (const float value : reader.tensor(name, shape)) {
    if (value != std::floor(value) || std::fabs(value) > 127.0f) {
      reader.fail(FileStatus::value_out_of_range, name + ": expected whole numbers from -127 to 127");
      return {};
    }
    bytes.push_back(static_cast<int8_t>(value));
  }
  return bytes;
}

void readDictionary(TensorReader& reader, Representation* code) {
  const uint64_t K = static_cast<uint64_t>(code->code_count);
  DictionaryData data;
  data.code_count = code->code_count;
  data.resolution = reader.integer("dictionary_resolution", 3, kMaxBrickResolution);
  const uint64_t r = static_cast<uint64_t>(data.resolution);
  data.nodes = readBytes(reader, "dictionary.nodes", {K + 1, r, r, r});
  data.exponents = readBytes(reader, "dictionary.exponents", {K + 1});
  data.deviations = reader.tensor("dictionary.deviations", {K});
  if (!reader.ok()) return;
  const std::string wrong = whatIsWrong(data);
  if (wrong.empty()) {
    *code = Representation::code(std::make_shared<Dictionary>(std::move(data)));
  } else {
    reader.fail(FileStatus::value_out_of_range, "dictionary: " + wrong);
  }
}

void writeDictionary(const DictionaryData& data, WeightsFile* file) {
  const auto floats = [](const std::vector<int8_t>& bytes) { return std::vector<float>(bytes.begin(), bytes.end()); };
  const uint64_t K = static_cast<uint64_t>(data.code_count), r = static_cast<uint64_t>(data.resolution);
  file->metadata["dictionary_resolution"] = std::to_string(data.resolution);
  file->tensors["dictionary.nodes"] = {{K + 1, r, r, r}, floats(data.nodes), WeightsDtype::float16};
  file->tensors["dictionary.exponents"] = {{K + 1}, floats(data.exponents)};
  file->tensors["dictionary.deviations"] = {{K}, data.deviations};
}

void writeLayers(const std::vector<GeneratorLayer>& layers, WeightsFile* file) {
  file->metadata["layer_count"] = std::to_string(layers.size());
  file->metadata["width"] = std::to_string(layers.front().output_count);
  for (size_t l = 0; l < layers.size(); ++l) {
    const GeneratorLayer& layer = layers[l];
    const uint64_t outputs = static_cast<uint64_t>(layer.output_count), inputs = static_cast<uint64_t>(layer.input_count);
    const std::string name = "layer." + std::to_string(l);
    file->tensors[name + ".weight"] = {{outputs, inputs}, layer.weight};
    file->tensors[name + ".bias"] = {{outputs}, layer.bias};
  }
}

}  // namespace

FileResult generatorFromWeights(const WeightsFile& file, GeneratorData* data) {
  *data = {};
  TensorReader reader(file);
  // version and pattern first: a basis of other support points fits no function
  const int version = reader.integer("version", 1, 1 << 20);
  if (version > kWeightsVersion) {
    reader.fail(FileStatus::version_unknown,
                "version " + std::to_string(version) + " is newer than this reader's " + std::to_string(kWeightsVersion));
  }
  const std::string pattern = reader.text("pattern_hash"), own = hexadecimal(supportPattern().hash);
  if (pattern != own) reader.fail(FileStatus::pattern_unknown, "support pattern " + shown(pattern) + ", expected " + own);
  const std::string representation = reader.text("representation");
  if (!findRepresentation(representation, &data->representation)) {
    reader.fail(FileStatus::value_out_of_range, "metadata representation: unknown " + shown(representation));
  }
  // the dictionary is part of a code's formula
  if (reader.ok() && data->representation.isCode()) readDictionary(reader, &data->representation);
  data->representation.slope = static_cast<float>(reader.number("representation_slope", 1e-6, 0.999));
  data->slope = static_cast<float>(reader.number("generator_slope", 1e-6, 0.999));
  // files of version 1 have coefficients, and do not say so
  if (version > 1) {
    const std::string input = reader.text("input");
    if (input != kSamples) reader.fail(FileStatus::value_out_of_range, "metadata input: expected samples, got " + shown(input));
    data->basis.input = GeneratorInput::samples;
  }
  readBasis(reader, &data->basis);
  const int theta_count = data->representation.thetaCount();
  // the shapes of the layers follow from the basis and D
  if (reader.ok()) data->layers = readLayers(reader, data->basis.coefficientCount(), theta_count);
  data->exact_last_layer = reader.integer("exact_last_layer", 0, 1) == 1;
  if (data->exact_last_layer && !data->representation.hasLinearOutput()) {
    reader.fail(FileStatus::value_out_of_range, "metadata exact_last_layer: the representation's output is not linear");
  }
  const std::vector<uint64_t> theta_shape = {static_cast<uint64_t>(data->representation.thetaCount())};
  data->theta0 = reader.tensor("theta0", theta_shape);
  data->output_scale = reader.tensor("output_scale", theta_shape);
  return reader.result();
}

WeightsFile weightsFromGenerator(const GeneratorData& data) {
  WeightsFile file;
  const bool reads_samples = data.basis.input == GeneratorInput::samples;
  const uint64_t length = static_cast<uint64_t>(inputCount(data.basis.input)),
                 count = static_cast<uint64_t>(data.basis.coefficientCount());
  // nine digits give back every float
  const auto number = [](double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", value);
    return std::string(text);
  };
  file.metadata["version"] = reads_samples ? "2" : "1";
  if (reads_samples) file.metadata["input"] = kSamples;
  file.metadata["pattern_hash"] = hexadecimal(supportPattern().hash);
  file.metadata["representation"] = representationName(data.representation);
  file.metadata["representation_slope"] = number(data.representation.slope);
  file.metadata["generator_slope"] = number(data.slope);
  file.metadata["exact_last_layer"] = data.exact_last_layer ? "1" : "0";
  for (int c = 0; c < kParityClassCount; ++c) {
    file.metadata["class_count." + std::to_string(c)] = std::to_string(data.basis.class_count[c]);
  }
  file.tensors["basis.components"] = {{count, length}, data.basis.components};
  if (!reads_samples) {
    file.tensors["basis.mean"] = {{uint64_t{kParityClassCount}, length}, data.basis.mean};
    file.tensors["basis.deviation"] = {{count}, data.basis.deviation};
  }
  writeLayers(data.layers, &file);
  if (data.representation.isCode()) writeDictionary(data.representation.dictionary->data(), &file);
  const std::vector<uint64_t> theta_shape = {data.theta0.size()};
  file.tensors["theta0"] = {theta_shape, data.theta0};
  file.tensors["output_scale"] = {theta_shape, data.output_scale};
  return file;
}

}  // namespace nlg
