#include "runtime_eval/evaluator/generator/matrix_product.h"

#include <gtest/gtest.h>

#include "tests/runtime_eval/each_target.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {
namespace {

struct Shape {
  int rows, inputs, outputs;
};

std::vector<float> randomValues(size_t count, uint64_t seed) {
  Random random(seed);
  std::vector<float> values(count);
  for (float& value : values) value = static_cast<float>(random.normal());
  return values;
}

// Every output against double; `stride` columns are read and written more than the matrix has, and must survive.
void expectProduct(const Shape& shape, Epilogue epilogue, float slope) {
  constexpr int kExtra = 3;
  const int input_stride = shape.inputs + kExtra, output_stride = shape.outputs + kExtra;
  const std::vector<float> weights = randomValues(size_t(shape.outputs) * shape.inputs, 1);
  const std::vector<float> bias = randomValues(shape.outputs, 2), input = randomValues(size_t(shape.rows) * input_stride, 3);
  const PackedMatrix matrix(weights.data(), shape.outputs, shape.inputs);
  ASSERT_EQ(matrix.inputCount(), shape.inputs);
  ASSERT_EQ(matrix.outputCount(), shape.outputs);
  std::vector<float> output(size_t(shape.rows) * output_stride, 99.0f);
  multiply({input.data(), input_stride}, shape.rows, matrix, bias.data(), epilogue, slope, output.data(), output_stride);
  for (int n = 0; n < shape.rows; ++n) {
    for (int o = 0; o < output_stride; ++o) {
      const float got = output[size_t(n) * output_stride + o];
      if (o >= shape.outputs) {
        ASSERT_EQ(got, 99.0f) << "written behind row " << n;
        continue;
      }
      double sum = bias[o], magnitude = std::fabs(bias[o]);
      for (int i = 0; i < shape.inputs; ++i) {
        const double term = double{weights[size_t(o) * shape.inputs + i]} * input[size_t(n) * input_stride + i];
        sum += term, magnitude += std::fabs(term);
      }
      if (epilogue != Epilogue::none && sum < 0) sum *= slope;
      if (epilogue == Epilogue::leaky_and_skip) {
        sum += input[size_t(n) * input_stride + o], magnitude += std::fabs(input[size_t(n) * input_stride + o]);
      }
      // one rounding a fused multiply-add, one for the slope, one for the skip
      ASSERT_NEAR(got, sum, (shape.inputs + 2) * kFloatRounding * magnitude)
          << shape.rows << " x " << shape.inputs << " x " << shape.outputs << ", row " << n << ", output " << o;
    }
  }
}

TEST(Multiply, EqualsDoubleOnRaggedShapesAndEveryTarget) {
  forEachTarget([] {
    for (const int rows : {1, 2, 7, 8, 9, 12, 13, 31, 95, 96, 97}) {
      for (const int outputs : {1, 7, 31, 32, 33, 113}) {
        expectProduct({rows, 19, outputs}, Epilogue::none, 1.0f);
        expectProduct({rows, 1, outputs}, Epilogue::leaky, 0.01f);
      }
    }
    expectProduct({257, 257, 257}, Epilogue::leaky, 0.3f);
  });
}

TEST(Multiply, AddsTheInputAfterTheLeakyUnit) {
  forEachTarget([] {
    for (const int rows : {1, 3, 12, 33, 97}) {
      for (const int width : {1, 5, 31, 32, 33, 64, 113}) expectProduct({rows, width, width}, Epilogue::leaky_and_skip, 0.1f);
    }
  });
}

}  // namespace
}  // namespace nlg
