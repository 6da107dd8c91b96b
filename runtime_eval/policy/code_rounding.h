// Rounds a code to bytes and as few numbers as suffice: each number compensates for those rounded or left out before it.
//
// To second order delta moves the sum of squares by |U delta|², U^T U = H, the normal equations where the fit ended. From the last number
// to the first, each is set to where its row of U delta is 0, then rounded: Babai's nearest plane, as compensated_rounding.h has it for
// networks. A number that is left out is one that was rounded to 0, so that what a shorter code costs is known before it is made.
#pragma once

#include <vector>

#include "runtime_eval/fit/code_fit.h"
#include "runtime_eval/policy/theta_rounding.h"

namespace nlg {

// One of these a thread.
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

}  // namespace nlg
