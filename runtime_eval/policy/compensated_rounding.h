// Rounds a network's hidden layers to steps (theta_form.h), each number compensating for those rounded before it.
//
// To second order the sum of squares grows by delta^T H delta, H = J^T J and delta what rounding moves. Rounding each number for itself
// ignores how they work together. Here they are rounded one after another, and each is first set to where it is best, given the ones
// before it and the best of all that follow: Babai's nearest plane (1986), as GPTQ has it for layers (Frantar et al. 2023).
// docs/theory/math.md §5; what it gains: docs/lab/training.md.
#pragma once

#include <vector>

#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/fit/normal_equations.h"

namespace nlg {

struct Compensation {
  UnitSteps most;
  // Of each diagonal entry of H, added to it: the less, the further numbers move to make up for others, and the further H leads astray.
  double damping = 0.03;
  int first_batch = 0;  // H is summed over some 2,000 points from this batch on
};

// One of these a thread: it keeps its workspace.
class CompensatedRounding {
 public:
  // Scales the hidden layers and rounds them; the last layer takes what makes up for them, and is not rounded.
  // theta     D finite floats
  // returns   false, and theta unchanged, when H cannot be factored or a number would not be finite
  bool round(const Representation& network, const WeightingFunction& function, const Compensation& compensation, float* theta);

 private:
  bool factor(double damping);

  NormalEquationsKernel kernel_;
  NormalEquations equations_;
  // H = M^T diag(d) M with M of unit lower triangle: delta^T H delta = sum_i d_i (delta_i + sum_{j < i} M_ij delta_j)², which the last
  // numbers bring to nothing whatever the first ones are. Row after row; d is gone once M is there.
  std::vector<double> rows_, moved_;
};

}  // namespace nlg
