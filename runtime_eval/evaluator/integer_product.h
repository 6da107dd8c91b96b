// Products of a batch of rows of 16-bit integers with one fixed matrix of 16-bit integers: the cheaper kind of matrix_product.h.
//
// Twice the multiply-adds of float32 an instruction, half the bytes, and sums that are exact: no order of summation, and no SIMD
// target, changes a bit of the result. Scales: docs/theory/inference.md §3.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime_eval/evaluator/matrix_product.h"
#include "runtime_eval/simd/aligned.h"

namespace nlg {

using AlignedIntegers = std::vector<int16_t, CacheLineAllocator<int16_t>>;

// A matrix (inputs x outputs), every output with a scale of its own, cut into panels of 32 outputs; inside, pairs of inputs.
class PackedIntegerMatrix {
 public:
  PackedIntegerMatrix() = default;
  // rows         outputs x inputs, row-major, finite: rounded to multiples of a step that is as fine as the 32-bit sums allow for
  //              inputs in ±input_limit
  // input_limit  1 to 32767
  PackedIntegerMatrix(const float* rows, int output_count, int input_count, int input_limit);

  int inputCount() const { return input_count_; }
  int outputCount() const { return output_count_; }
  // What one unit of an output's sum is worth.
  const float* steps() const { return steps_.data(); }
  // Σ of an output's integer weights.
  int weightSum(int output) const;
  static constexpr int kPanelWidth = 32;
  int pairCount() const { return (input_count_ + 1) / 2; }
  const int16_t* panel(int index) const { return &panels_[size_t(index) * pairCount() * 2 * kPanelWidth]; }

 private:
  int input_count_ = 0, output_count_ = 0;
  AlignedIntegers panels_;
  AlignedFloats steps_;  // padded to whole panels
};

// Rows of integers, each with a scale: value = scale * integer. An odd number of inputs is followed by one zero.
struct IntegerRows {
  const int16_t* values;
  int stride;           // integers from one row to the next, even
  const float* scales;  // of the rows; null: 1 each
};

// The largest magnitude that quantiseRows makes.
inline constexpr int kActivationLimit = 4095;

// Rows of floats as integers in ±kActivationLimit, each row by a scale that its largest magnitude sets; a row whose values are
// all below 1e-30 becomes zeros.
// rows      row_count x count, dense
// integers  row_count x stride, the pad up to an even count filled with a zero
void quantiseRows(const float* rows, int row_count, int count, int16_t* integers, int stride, float* scales);

// output(n, :) = epilogue(input(n, :) · matrix + bias), in units of the values that the integers stand for.
// bias    outputCount() floats
// skip    row_count x outputCount() floats, dense, added where the epilogue says so; otherwise ignored
// output  row_count x outputCount() with output_stride floats from row to row; must not overlap input or skip
void multiply(IntegerRows input, int row_count, const PackedIntegerMatrix& matrix, const float* bias, Epilogue epilogue,
              float slope, const float* skip, float* output, int output_stride);

}  // namespace nlg
