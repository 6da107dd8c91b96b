#include "runtime_eval/evaluator/integer_product.h"

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

// What quantiseRows and PackedIntegerMatrix stand for, with the error that their rounding may make, in double.
struct Expected {
  double value, error;
};

Expected expected(const float* weights, const float* input, int inputs, double bias, float step, float scale) {
  Expected result{bias, 0.0};
  for (int i = 0; i < inputs; ++i) {
    result.value += double{weights[i]} * input[i];
    // half a unit of each factor, by what it is multiplied with; both are rounded, so half of both more
    result.error += 0.5 * step * std::fabs(input[i]) + 0.5 * scale * std::fabs(weights[i]) + 0.25 * double{step} * scale;
  }
  return result;
}

std::vector<float> product(const Shape& shape, Epilogue epilogue, float slope, bool check) {
  const std::vector<float> weights = randomValues(size_t(shape.outputs) * shape.inputs, 1);
  const std::vector<float> bias = randomValues(shape.outputs, 2), input = randomValues(size_t(shape.rows) * shape.inputs, 3);
  const PackedIntegerMatrix matrix(weights.data(), shape.outputs, shape.inputs, kActivationLimit);
  const int stride = shape.inputs + 4 + shape.inputs % 2, output_stride = shape.outputs + 3;
  AlignedIntegers integers(size_t(shape.rows) * stride, 77);
  std::vector<float> scales(shape.rows), output(size_t(shape.rows) * output_stride, 99.0f);
  quantiseRows(input.data(), shape.rows, shape.inputs, integers.data(), stride, scales.data());
  multiply({integers.data(), stride, scales.data()}, shape.rows, matrix, bias.data(), epilogue, slope, input.data(),
           output.data(), output_stride);
  for (int n = 0; check && n < shape.rows; ++n) {
    for (int o = 0; o < output_stride; ++o) {
      const float got = output[size_t(n) * output_stride + o];
      if (o >= shape.outputs) {
        EXPECT_EQ(got, 99.0f) << "written behind row " << n;
        continue;
      }
      const float* row = &input[size_t(n) * shape.inputs];
      Expected exact = expected(&weights[size_t(o) * shape.inputs], row, shape.inputs, bias[o], matrix.steps()[o], scales[n]);
      if (epilogue != Epilogue::none && exact.value < 0) exact.value *= slope;
      if (epilogue == Epilogue::leaky_and_skip) exact.value += row[o];
      // the epilogue rounds six times, at most the magnitude of the sum and of what is added
      const double rounding = 6 * kFloatRounding * (std::fabs(exact.value) + std::fabs(bias[o]) + exact.error + 10.0);
      EXPECT_NEAR(got, exact.value, exact.error + rounding)
          << shape.rows << " x " << shape.inputs << " x " << shape.outputs << ", row " << n << ", output " << o;
    }
  }
  return output;
}

TEST(IntegerMultiply, EqualsDoubleOnRaggedShapesAndEveryTarget) {
  forEachTarget([] {
    for (const int rows : {1, 2, 7, 8, 9, 12, 13, 31, 96, 97}) {
      for (const int outputs : {1, 7, 31, 32, 33, 113}) {
        product({rows, 19, outputs}, Epilogue::none, 1.0f, true);
        product({rows, 1, outputs}, Epilogue::leaky, 0.01f, true);
      }
    }
    product({193, 257, 65}, Epilogue::leaky, 0.3f, true);
    product({3, 600, 33}, Epilogue::none, 1.0f, true);
  });
}

TEST(IntegerMultiply, AddsTheFloatsAfterTheLeakyUnit) {
  forEachTarget([] {
    for (const int rows : {1, 3, 12, 33, 97}) {
      for (const int width : {1, 5, 31, 32, 33, 64, 113}) product({rows, width, width}, Epilogue::leaky_and_skip, 0.1f, true);
    }
  });
}

TEST(IntegerMultiply, IsBitIdenticalOnEveryTarget) {
  for (const Shape& shape : {Shape{1, 300, 113}, Shape{13, 64, 64}, Shape{97, 113, 113}}) {
    const Epilogue epilogue = shape.inputs == shape.outputs ? Epilogue::leaky_and_skip : Epilogue::leaky;
    ASSERT_EQ(forceSimdTarget("scalar"), SimdStatus::ok);
    const std::vector<float> scalar = product(shape, epilogue, 0.1f, false);
    forEachTarget([&] { EXPECT_EQ(product(shape, epilogue, 0.1f, false), scalar); });
  }
  forceSimdTarget("");
}

TEST(IntegerMultiply, HoldsTheLargestSumsIn32Bits) {
  // all inputs at their limit, all weights of one sign: the sum that the scale was chosen for
  for (const int inputs : {2, 511, 512, 1024}) {
    for (const int limit : {kActivationLimit, 1020}) {
      const std::vector<float> weights(inputs, -0.7f);
      const PackedIntegerMatrix matrix(weights.data(), 1, inputs, limit);
      EXPECT_LE(std::fabs(static_cast<double>(matrix.weightSum(0))) * limit, 2147483647.0);
      const int stride = inputs + inputs % 2;
      AlignedIntegers input(stride, 0);
      std::fill_n(input.begin(), inputs, static_cast<int16_t>(limit));
      const float bias = 0.0f;
      forEachTarget([&] {
        float output = 0.0f;
        multiply({input.data(), stride, nullptr}, 1, matrix, &bias, Epilogue::none, 1.0f, nullptr, &output, 1);
        // half a step a weight, by the limit each
        EXPECT_NEAR(output, -0.7 * inputs * limit, 0.5 * matrix.steps()[0] * inputs * limit + 1e-6 * inputs * limit) << inputs;
      });
    }
  }
}

TEST(IntegerMultiply, TakesMatricesOfZeros) {
  const std::vector<float> weights(40, 0.0f), bias = {3.0f, -4.0f};
  const PackedIntegerMatrix matrix(weights.data(), 2, 20, kActivationLimit);
  const AlignedIntegers input(20, 4095);
  float output[2] = {};
  multiply({input.data(), 20, nullptr}, 1, matrix, bias.data(), Epilogue::none, 1.0f, nullptr, output, 2);
  EXPECT_EQ(output[0], 3.0f);
  EXPECT_EQ(output[1], -4.0f);
}

TEST(QuantiseRows, KeepsEveryValueToHalfAStep) {
  forEachTarget([] {
    for (const int count : {1, 2, 15, 16, 17, 33, 512}) {
      const std::vector<float> rows = randomValues(size_t(3) * count, 4);
      const int stride = count + count % 2;
      AlignedIntegers integers(size_t(3) * stride, 77);
      float scales[3];
      quantiseRows(rows.data(), 3, count, integers.data(), stride, scales);
      for (int n = 0; n < 3; ++n) {
        int largest = 0;
        for (int i = 0; i < count; ++i) {
          const int integer = integers[n * stride + i];
          largest = std::max(largest, std::abs(integer));
          // two roundings of the scaled value beside the one to an integer
          ASSERT_NEAR(integer * double{scales[n]}, rows[n * count + i],
                      scales[n] * (0.5 + 4 * kFloatRounding * kActivationLimit));
        }
        EXPECT_EQ(largest, kActivationLimit) << "row " << n << " of " << count;
        if (count % 2 != 0) {
          EXPECT_EQ(integers[n * stride + count], 0);
        }
      }
    }
  });
}

TEST(QuantiseRows, TakesRowsOfZerosAndOfDenormals) {
  forEachTarget([] {
    for (const float value : {0.0f, -0.0f, 1e-40f, 1e-31f}) {
      const std::vector<float> row(20, value);
      AlignedIntegers integers(20, 77);
      float scale = 5.0f;
      quantiseRows(row.data(), 1, 20, integers.data(), 20, &scale);
      for (const int16_t integer : integers) ASSERT_EQ(integer, 0) << value;
      EXPECT_LT(scale, 1e-30f);
    }
  });
}

}  // namespace
}  // namespace nlg
