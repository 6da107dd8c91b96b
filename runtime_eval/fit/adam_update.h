// One step of Adam on a vector of parameters, for any SIMD target.
#pragma once

#include <vector>

#include "runtime_eval/simd/aligned.h"

namespace nlg {

// The moments of one fit, kept between its steps.
class AdamMoments {
 public:
  AdamMoments() = default;
  // count   of parameters
  explicit AdamMoments(int count) { reset(count); }
  // As at the start of a fit; of no more parameters than before it allocates nothing.
  void reset(int count);

  // theta -= learning_rate * mean / (sqrt(square) + 1e-8), both moments without the bias of their start (Kingma & Ba 2015).
  // gradient, theta   count floats; the gradient is multiplied by gradient_scale first
  void step(double learning_rate, double beta1, double beta2, float gradient_scale, const float* gradient, float* theta);

 private:
  AlignedFloats mean_, square_;
  double mean_power_ = 1.0, square_power_ = 1.0;
};

}  // namespace nlg
