#include "export/onnx_file/onnx_file.h"

#include <onnx/checker.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "runtime_eval/numbers/half.h"

static_assert(std::endian::native == std::endian::little, "ONNX keeps raw data little-endian");

namespace nlg {
namespace {

using Names = std::vector<std::string>;
using Shape = std::vector<int64_t>;

constexpr int kIrVersion = 8, kOpset = 17;

bool fitsFloat16(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float value) {
    Half half;
    return halfFromFloat(value, &half) && floatFromHalf(half) == value;
  });
}

// A model in the making: values are known by name, nodes stand in the order in which they are computed.
class ModelBuilder {
 public:
  ModelBuilder(const std::string& name, const std::map<std::string, std::string>& metadata) {
    model_.set_ir_version(kIrVersion);
    model_.set_producer_name("nlg-export");
    model_.add_opset_import()->set_version(kOpset);
    for (const auto& [key, value] : metadata) {
      onnx::StringStringEntryProto* entry = model_.add_metadata_props();
      entry->set_key(key);
      entry->set_value(value);
    }
    graph().set_name(name);
  }

  std::string input(const std::string& name, int64_t width) {
    describe(graph().add_input(), name, width);
    return name;
  }
  void output(const std::string& name, int64_t width) { describe(graph().add_output(), name, width); }

  std::string numbers(const std::string& name, const Shape& shape, const std::vector<float>& values) {
    store(name, shape, onnx::TensorProto::FLOAT, values);
    return name;
  }

  // As numbers, but small where that loses nothing.
  std::string matrix(const std::string& name, const Shape& shape, const std::vector<float>& values) {
    if (!fitsFloat16(values)) return numbers(name, shape, values);
    std::vector<Half> halves(values.size());
    for (size_t i = 0; i < values.size(); ++i) halfFromFloat(values[i], &halves[i]);
    store(name + ".float16", shape, onnx::TensorProto::FLOAT16, halves);
    onnx::AttributeProto* to = attribute(node("Cast", {name + ".float16"}, {name}), "to", onnx::AttributeProto::INT);
    to->set_i(onnx::TensorProto::FLOAT);
    return name;
  }

  std::string reshape(const std::string& from, const Shape& shape, const std::string& to) {
    store(to + ".shape", {static_cast<int64_t>(shape.size())}, onnx::TensorProto::INT64, shape);
    return apply("Reshape", {from, to + ".shape"}, to);
  }

  std::string apply(const char* operation, const Names& inputs, const std::string& output) {
    node(operation, inputs, {output});
    return output;
  }

  // Parts of equal size along axis 1.
  void split(const std::string& from, const Names& parts) {
    attribute(node("Split", {from}, parts), "axis", onnx::AttributeProto::INT)->set_i(1);
  }
  std::string join(const Names& parts, const std::string& to, int64_t axis = 1) {
    attribute(node("Concat", parts, {to}), "axis", onnx::AttributeProto::INT)->set_i(axis);
    return to;
  }
  // values * transposed matrix (+ bias)
  std::string product(const Names& values_matrix_bias, const std::string& to) {
    attribute(node("Gemm", values_matrix_bias, {to}), "transB", onnx::AttributeProto::INT)->set_i(1);
    return to;
  }
  std::string leaky(const std::string& from, float slope, const std::string& to) {
    attribute(node("LeakyRelu", {from}, {to}), "alpha", onnx::AttributeProto::FLOAT)->set_f(slope);
    return to;
  }

  std::string bytes() const {
    onnx::checker::check_model(model_);
    return model_.SerializeAsString();
  }

 private:
  onnx::GraphProto& graph() { return *model_.mutable_graph(); }

  static void describe(onnx::ValueInfoProto* value, const std::string& name, int64_t width) {
    value->set_name(name);
    onnx::TypeProto::Tensor* tensor = value->mutable_type()->mutable_tensor_type();
    tensor->set_elem_type(onnx::TensorProto::FLOAT);
    tensor->mutable_shape()->add_dim()->set_dim_param("N");
    tensor->mutable_shape()->add_dim()->set_dim_value(width);
  }

  onnx::NodeProto* node(const char* operation, const Names& inputs, const Names& outputs) {
    onnx::NodeProto* node = graph().add_node();
    node->set_op_type(operation);
    node->set_name(outputs.front());
    for (const std::string& input : inputs) node->add_input(input);
    for (const std::string& output : outputs) node->add_output(output);
    return node;
  }

  static onnx::AttributeProto* attribute(onnx::NodeProto* node, const char* name, onnx::AttributeProto::AttributeType type) {
    onnx::AttributeProto* attribute = node->add_attribute();
    attribute->set_name(name);
    attribute->set_type(type);
    return attribute;
  }

  template <class Value>
  void store(const std::string& name, const Shape& shape, onnx::TensorProto::DataType type, const std::vector<Value>& values) {
    onnx::TensorProto* tensor = graph().add_initializer();
    tensor->set_name(name);
    tensor->set_data_type(type);
    for (const int64_t extent : shape) tensor->add_dims(extent);
    tensor->set_raw_data(values.data(), values.size() * sizeof(Value));
  }

  onnx::ModelProto model_;
};

// The channels of samples, N x 8 x 384: the formulas of docs/theory/math.md §6.
std::string addChannels(ModelBuilder& model, const std::string& phi, const std::string& valid) {
  std::vector<float> inverse_tents;
  for (int j = 0; j < kSamplePointCount; ++j)
    inverse_tents.push_back(1.0f / std::max(kLeastTent, tent(supportPattern().points[supportPointOf(j)])));
  const auto number = [&](const std::string& name, float value) { return model.numbers(name, {1}, {value}); };
  const std::string factor = number("channel.factor", 0.3f);
  const std::string ratio =
      model.apply("Mul", {phi, model.numbers("tents.inverse", {kSamplePointCount}, inverse_tents)}, "ratio");
  const std::string visibility = model.apply("Min", {ratio, number("one", 1.0f)}, "visibility");
  const std::string centred = model.apply("Sub", {visibility, number("visibility.offset", 0.7f)}, "visibility.centred");
  const std::string masked = model.apply("Mul", {centred, valid}, "visibility.masked");
  const std::string validity = model.apply("Sub", {valid, number("valid.offset", 0.9f)}, "valid.centred");
  Names channels = {phi, model.apply("Mul", {masked, factor}, "visibility.channel"),
                    model.apply("Mul", {validity, factor}, "valid.channel")};
  for (std::string& channel : channels)
    channel = model.reshape(channel, {-1, kMirrorCount, kOctantSampleCount}, channel + ".octants");
  return model.join(channels, "octants", 2);
}

// Coefficients, divided as the basis says: the formulas of docs/theory/math.md §3, class by class.
// octants   N x 8 x inputCount(basis.input): what components weigh, by mirror
std::string addProjection(ModelBuilder& model, const BasisData& basis, const std::string& octants) {
  constexpr int64_t kClasses = kParityClassCount;
  const int64_t length = inputCount(basis.input);
  std::vector<float> signs;
  for (int c = 0; c < kClasses; ++c) {
    for (int m = 0; m < kMirrorCount; ++m) signs.push_back(static_cast<float>(mirrorSign(c, m) / std::sqrt(8.0)));
  }
  // the parity transform as one product with signs (docs/theory/math.md §2)
  const std::string transformed =
      model.apply("MatMul", {model.numbers("parity.signs", {kClasses, kMirrorCount}, signs), octants}, "parity");
  const std::string centred =
      basis.mean.empty()
          ? transformed
          : model.apply("Sub", {transformed, model.numbers("basis.mean", {kClasses, length}, basis.mean)}, "parity.centred");
  Names classes;
  for (int c = 0; c < kClasses; ++c) classes.push_back("parity.class." + std::to_string(c));
  model.split(model.reshape(centred, {-1, kClasses * length}, "parity.flat"), classes);

  // class by class, since a component has numbers in one class alone
  Names coefficients;
  auto first = basis.components.begin();
  for (int c = 0; c < kClasses; ++c) {
    const int count = basis.class_count[c];
    if (count == 0) continue;
    const auto last = first + int64_t{count} * length;
    const std::string name = std::to_string(c);
    const std::string components = model.matrix("basis.components." + name, {count, length}, {first, last});
    coefficients.push_back(model.product({classes[c], components}, "coefficients.class." + name));
    first = last;
  }
  const std::string raw = model.join(coefficients, "coefficients.raw");
  const std::string deviation = model.numbers("basis.deviation", {basis.coefficientCount()}, basis.deviation);
  return model.apply("Div", {raw, deviation}, "coefficients");
}

// output = output_scale * last layer.
std::string addLayers(ModelBuilder& model, const GeneratorData& data, std::string values, const std::string& output) {
  for (size_t l = 0; l < data.layers.size(); ++l) {
    const GeneratorLayer& layer = data.layers[l];
    const std::string name = "layer." + std::to_string(l);
    const std::string weight = model.matrix(name + ".weight", {layer.output_count, layer.input_count}, layer.weight);
    const std::string bias = model.numbers(name + ".bias", {layer.output_count}, layer.bias);
    const std::string product = model.product({values, weight, bias}, name + ".product");
    if (l + 1 == data.layers.size()) {
      const std::string factor = model.numbers("output_scale", {layer.output_count}, data.output_scale);
      return model.apply("Mul", {product, factor}, output);
    }
    const std::string hidden = model.leaky(product, data.slope, name + ".hidden");
    values = layer.input_count == layer.output_count ? model.apply("Add", {hidden, values}, name + ".skip") : hidden;
  }
  return values;
}

}  // namespace

std::string onnxFromGenerator(const GeneratorData& data, const std::map<std::string, std::string>& metadata) {
  ModelBuilder model("generator", metadata);
  const auto theta_count = static_cast<int64_t>(data.theta0.size());
  const bool reads_samples = data.basis.input == GeneratorInput::samples;
  const std::string phi = model.input("phi", reads_samples ? kSamplePointCount : kSupportPointCount);
  const std::string octants = reads_samples ? addChannels(model, phi, model.input("valid", kSamplePointCount))
                                            : model.reshape(phi, {-1, kMirrorCount, kOctantPointCount}, "octants");
  const std::string coefficients = addProjection(model, data.basis, octants);
  const std::string change = addLayers(model, data, coefficients, "theta.change");
  model.apply("Add", {change, model.numbers("theta0", {theta_count}, data.theta0)}, "theta");
  model.output("theta", theta_count);
  model.output("coefficients", data.basis.coefficientCount());
  return model.bytes();
}

}  // namespace nlg
