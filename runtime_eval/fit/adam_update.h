// One step of Adam on a vector of parameters, for any SIMD target.
#pragma once

#include <cstdint>
#include <vector>

#include "nlg/representation.h"
#include "runtime_eval/simd/aligned.h"

namespace nlg {

struct AdamStep {
  double learning_rate = 0.0, beta1 = 0.9, beta2 = 0.999;
  double beta1_power = 0.0, beta2_power = 0.0;  // the betas to the power of this step's number, from 1: what the start's bias is
  float gradient_scale = 1.0f;                  // the gradient is multiplied by it first
};

// theta -= learning_rate * mean / (sqrt(square) + 1e-8), both moments without the bias of their start (Kingma & Ba 2015).
// gradient, mean, square, theta   count floats; mean and square are the moments, 0 before the first step
void adamUpdate(const AdamStep& step, int64_t count, const float* gradient, float* mean, float* square, float* theta);

// The moments of one fit, kept between its steps.
class AdamMoments {
 public:
  AdamMoments() = default;
  // count   of parameters
  explicit AdamMoments(int count) { reset(count); }
  // As at the start of a fit; of no more parameters than before it allocates nothing.
  void reset(int count);

  // The next step, by adamUpdate().
  // gradient, theta   count floats
  void step(double learning_rate, double beta1, double beta2, float gradient_scale, const float* gradient, float* theta);

 private:
  AlignedFloats mean_, square_;
  double mean_power_ = 1.0, square_power_ = 1.0;
};

// One step of SOAP on the parameters of a network, for any SIMD target: Adam in the eigenbasis of Shampoo's preconditioner
// (Vyas et al. 2024). Fits of tiny networks need half of the steps that plain Adam takes. docs/theory/math.md §5.

// The moments of one fit, kept between its steps. Gradients of a hidden layer are a matrix G of R rows, one an output, and C
// columns, its inputs and the constant 1 of its biases; the last layer, a single row, takes steps of plain Adam.
class SoapMoments {
 public:
  // As at the start of a fit; allocates nothing after the first call.
  void reset(const Representation& network);

  // As AdamMoments::step, of the network's D parameters.
  void step(double learning_rate, double beta1, double beta2, float gradient_scale, const float* gradient, float* theta);

  // Rows of a matrix lie a whole vector apart.
  static constexpr int kStride = 16;
  struct alignas(64) Matrix {
    float at[kStride][kStride];
  };
  struct Layer {
    // decaying sums of G G^T (R x R) and G^T G (C x C)
    Matrix left, right;
    // their eigenvectors: one a column, and the same transposed
    Matrix left_vectors, left_rows, right_vectors, right_rows;
    // in that basis, R x C
    Matrix mean, square;
  };

 private:
  Representation network_;
  int steps_ = 0;
  double mean_power_ = 1.0, square_power_ = 1.0, factor_power_ = 1.0;  // decays to the power of steps_
  std::vector<Layer, CacheLineAllocator<Layer>> layers_;               // hidden ones
  AdamMoments last_;
};

}  // namespace nlg
