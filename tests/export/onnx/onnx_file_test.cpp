#include "export/onnx_file/onnx_file.h"

#include <gtest/gtest.h>
#include <onnx/onnx_pb.h>
#include <onnx/shape_inference/implementation.h>

#include "runtime_eval/numbers/half.h"
#include "tests/runtime_eval/sample_generator.h"

namespace nlg {
namespace {

onnx::ModelProto parsed(const std::string& bytes) {
  onnx::ModelProto model;
  EXPECT_TRUE(model.ParseFromString(bytes));
  return model;
}

const onnx::TensorProto& initializer(const onnx::ModelProto& model, const std::string& name) {
  for (const onnx::TensorProto& tensor : model.graph().initializer())
    if (tensor.name() == name) return tensor;
  ADD_FAILURE() << "no initialiser " << name;
  static const onnx::TensorProto kNone;
  return kNone;
}

std::vector<int64_t> dimensions(const onnx::TensorProto& tensor) { return {tensor.dims().begin(), tensor.dims().end()}; }

std::vector<float> floats(const onnx::TensorProto& tensor) {
  EXPECT_EQ(tensor.data_type(), onnx::TensorProto::FLOAT) << tensor.name();
  std::vector<float> values(tensor.raw_data().size() / sizeof(float));
  std::memcpy(values.data(), tensor.raw_data().data(), tensor.raw_data().size());
  return values;
}

int nodeCount(const onnx::ModelProto& model, const std::string& operation) {
  return static_cast<int>(std::count_if(model.graph().node().begin(), model.graph().node().end(),
                                        [&](const onnx::NodeProto& node) { return node.op_type() == operation; }));
}

void roundAll(std::vector<float>* values) {
  for (float& value : *values) {
    Half half;
    ASSERT_TRUE(halfFromFloat(value, &half));
    value = floatFromHalf(half);
  }
}

// ONNX's own shape inference, in its strict mode, comes to the shapes that the model states.
TEST(OnnxFile, HasShapesThatFollowFromItsNodes) {
  for (const int layer_count : {1, 2, 4}) {
    onnx::ModelProto model = parsed(onnxFromGenerator(sampleGenerator(Representation::mlp(), 25, layer_count, 2), {}));
    for (onnx::ValueInfoProto& output : *model.mutable_graph()->mutable_output()) {
      output.mutable_type()->mutable_tensor_type()->clear_shape();
    }
    const onnx::ShapeInferenceOptions strict{true, 1, false};
    ASSERT_NO_THROW(onnx::shape_inference::InferShapes(model, onnx::OpSchemaRegistry::Instance(), strict));
    std::map<std::string, int64_t> width;
    for (const onnx::ValueInfoProto& output : model.graph().output()) {
      const onnx::TensorShapeProto& shape = output.type().tensor_type().shape();
      ASSERT_EQ(shape.dim_size(), 2) << output.name();
      width[output.name()] = shape.dim(1).dim_value();
    }
    EXPECT_EQ(width, (std::map<std::string, int64_t>{{"theta", 113}, {"coefficients", 25}})) << layer_count;
  }
}

TEST(OnnxFile, HoldsTheGeneratorsNumbers) {
  // layers 25 → 25 → 25 → 113: the first two have a skip
  const GeneratorData data = sampleGenerator(Representation::tentMlp(), 25, 3, 3);
  const onnx::ModelProto model = parsed(onnxFromGenerator(data, {}));
  EXPECT_EQ(floats(initializer(model, "basis.mean")), data.basis.mean);
  EXPECT_EQ(floats(initializer(model, "basis.deviation")), data.basis.deviation);
  EXPECT_EQ(floats(initializer(model, "theta0")), data.theta0);
  EXPECT_EQ(floats(initializer(model, "output_scale")), data.output_scale);
  std::vector<float> components;
  for (int c = 0; c < kParityClassCount; ++c) {
    if (data.basis.class_count[c] == 0) continue;
    const onnx::TensorProto& part = initializer(model, "basis.components." + std::to_string(c));
    EXPECT_EQ(dimensions(part), (std::vector<int64_t>{data.basis.class_count[c], 1024})) << c;
    const std::vector<float> values = floats(part);
    components.insert(components.end(), values.begin(), values.end());
  }
  EXPECT_EQ(components, data.basis.components);
  for (size_t l = 0; l < data.layers.size(); ++l) {
    const std::string name = "layer." + std::to_string(l);
    EXPECT_EQ(floats(initializer(model, name + ".weight")), data.layers[l].weight) << l;
    EXPECT_EQ(dimensions(initializer(model, name + ".weight")), (std::vector<int64_t>{data.layers[l].output_count, 25})) << l;
    EXPECT_EQ(floats(initializer(model, name + ".bias")), data.layers[l].bias) << l;
  }
  EXPECT_EQ(nodeCount(model, "LeakyRelu"), 2);
  EXPECT_EQ(nodeCount(model, "Add"), 3) << "two skips and theta0";
  // class 4 of the sample has no component
  EXPECT_EQ(nodeCount(model, "Gemm"), 7 + 3);
}

TEST(OnnxFile, StoresMatricesAsFloat16OnlyWhereThatLosesNothing) {
  GeneratorData data = sampleGenerator(Representation::mlp(), 24, 2, 4);
  const size_t float32_bytes = onnxFromGenerator(data, {}).size();
  roundAll(&data.basis.components);
  roundAll(&data.layers[1].weight);
  const std::string bytes = onnxFromGenerator(data, {});
  const onnx::ModelProto model = parsed(bytes);
  const onnx::TensorProto& weight = initializer(model, "layer.1.weight.float16");
  EXPECT_EQ(weight.data_type(), onnx::TensorProto::FLOAT16);
  ASSERT_EQ(weight.raw_data().size(), data.layers[1].weight.size() * 2);
  for (size_t i = 0; i < data.layers[1].weight.size(); ++i) {
    Half half;
    std::memcpy(&half, weight.raw_data().data() + 2 * i, 2);
    ASSERT_EQ(floatFromHalf(half), data.layers[1].weight[i]) << i;
  }
  EXPECT_EQ(floats(initializer(model, "layer.0.weight")), data.layers[0].weight);
  EXPECT_EQ(nodeCount(model, "Cast"), 7 + 1) << "classes with components, and a layer";
  EXPECT_LT(bytes.size() + data.basis.components.size() * 2, float32_bytes + 2000);
}

}  // namespace
}  // namespace nlg
