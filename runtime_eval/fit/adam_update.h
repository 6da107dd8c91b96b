// One step of Adam on a vector of parameters, for any SIMD target.
#pragma once

#include <cstdint>

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

}  // namespace nlg
