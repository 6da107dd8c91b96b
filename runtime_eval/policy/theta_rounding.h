// Rounds theta to the light grid's precision, in the best of several ways if one does not pass the check.
#pragma once

#include <memory>
#include <vector>

#include "nlg/policy.h"
#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/fit/code_fit.h"
#include "runtime_eval/fit/normal_equations.h"

namespace nlg {

struct RoundedTheta {
  Theta theta;
  FunctionCheck check;
};

// Rounds a network's hidden layers to steps (theta_form.h), each number compensating for those rounded before it.
//
// To second order the sum of squares grows by delta^T H delta, H = J^T J and delta what rounding moves. Rounding each number for itself
// ignores how they work together. Here they are rounded one after another, and each is first set to where it is best, given the ones
// before it and the best of all that follow: Babai's nearest plane (1986), as GPTQ has it for layers (Frantar et al. 2023).
// docs/theory/math.md §5; what it gains: docs/lab/training.md.
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

// Rounds a code to bytes and as few numbers as suffice: each number compensates for those rounded or left out before it.
//
// To second order delta moves the sum of squares by |U delta|², U^T U = H, the normal equations where the fit ended. From the last number
// to the first, each is set to where its row of U delta is 0, then rounded: Babai's nearest plane, as for networks. A number that is left out is one that was rounded to 0, so that what a shorter code costs is known before it is made. One of these a thread.
class CodeRounding {
 public:
  explicit CodeRounding(const CodeOptions& options) : options_(options) {}

  // The shortest code that passes where the present one does, and whose weighed RMSE is at most code_flat_ratio times that of the present
  // one, or code_enough_rmse; of all K numbers where none is.
  // present   a code with what the check found of it
  RoundedTheta round(const Representation& representation, const StoredFunction& function, const RoundedTheta& present,
                     const CheckOptions& check);

 private:
  // U of the equations at z; false where they cannot be factored.
  bool factorAt(const Representation& representation, const float* z);
  // The first `length` numbers of z, rounded; those behind are 0.
  Theta rounded(const float* z, int length) const;

  CodeOptions options_;
  CodeFit fit_;
  FunctionChecker checker_;
  WeightingFunction function_;
  CodeEquations equations_;
};

// One of these a thread: for int8 it holds half a megabyte.
class ThetaRounding {
 public:
  // theta_precision   float16 or int8
  explicit ThetaRounding(const PolicyOptions& options);

  // A number beyond float16 becomes the largest that it has.
  // present   a theta with what the check found of it
  RoundedTheta round(const Representation& representation, const StoredFunction& function, const RoundedTheta& present,
                     const CheckOptions& check);

 private:
  RoundedTheta roundToHalves(const Representation& field, const StoredFunction& function, const Theta& theta,
                             const CheckOptions& check);
  RoundedTheta roundToBytes(const Representation& network, const StoredFunction& function, const RoundedTheta& present,
                            const CheckOptions& check);

  std::unique_ptr<CompensatedRounding> compensated_;  // these two for int8 alone
  std::unique_ptr<CodeRounding> code_;
  FunctionChecker checker_;
};

}  // namespace nlg
