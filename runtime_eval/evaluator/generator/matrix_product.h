// Multiplies a batch of row vectors with one fixed matrix, for the generator's layers and the projection.
#pragma once

#include "runtime_eval/simd/aligned.h"

namespace nlg {

// A matrix (inputs x outputs) cut into panels of 32 outputs, inputs-major inside, as the kernel streams it.
class PackedMatrix {
 public:
  PackedMatrix() = default;
  // rows   outputs x inputs, row-major (a layer's weights, a basis's components): the transpose is packed
  PackedMatrix(const float* rows, int output_count, int input_count);

  int inputCount() const { return input_count_; }
  int outputCount() const { return output_count_; }
  static constexpr int kPanelWidth = 32;
  const float* panel(int index) const { return &panels_[size_t(index) * input_count_ * kPanelWidth]; }
  int panelCount() const { return (output_count_ + kPanelWidth - 1) / kPanelWidth; }

 private:
  int input_count_ = 0, output_count_ = 0;
  AlignedFloats panels_;
};

// What becomes of input · matrix + bias.
enum class Epilogue {
  none,            // nothing
  leaky,           // LeakyReLU
  leaky_and_skip,  // LeakyReLU, then the input is added (inputs == outputs)
};

struct RowMatrix {
  const float* values;
  int stride;  // floats from one row to the next
};

// output(n, :) = epilogue(input(n, :) · matrix + bias) for n in [0, row_count).
// bias      outputCount() floats
// slope     of the LeakyReLU, in (0, 1]
// output    row_count x outputCount() with output_stride floats from row to row; must not overlap input
void multiply(RowMatrix input, int row_count, const PackedMatrix& matrix, const float* bias, Epilogue epilogue, float slope,
              float* output, int output_stride);

}  // namespace nlg
