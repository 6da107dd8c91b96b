// Whether a theta may stand for its function: the check after the generator (the talk: "if the error is too high …").
#pragma once

#include "runtime_eval/fit/policy_options.h"
#include "runtime_eval/support/weighting_function.h"

namespace nlg {

// One theta against one stored function, over all valid support points. A bake does not store what the probe sees: leaks are counted at
// all points whose phi is 0, a few of which it does see, at the tent's rim.
struct FunctionCheck {
  double rmse = 0.0;  // 0 when no point is valid; not finite, whatever the points, when theta is not
  double blend_rmse =
      0.0;  // the root of the loss (loss_weights.h), likewise: what fits minimise, and of two theta the lower one wins
  double leak_mean = 0.0;   // mean |value| over valid points whose phi is stored as 0; 0 when there are none
  double leak_share = 0.0;  // share of them with |value| above tau_leak of the tent and what a byte's rounding hides
  int valid_count = 0;
  int zero_count = 0;  // valid points whose phi is stored as 0

  bool passes(const CheckOptions& options) const { return trouble(options) <= 1.0; }
  // The larger of both RMSEs, each over what is allowed; infinite when theta is not finite. Above 1 the check fails.
  double trouble(const CheckOptions& options) const;
};

// One of these a thread: it keeps the values between checks, so that none of them allocates.
class FunctionChecker {
 public:
  FunctionChecker();

  // theta   D floats
  FunctionCheck check(const Representation& representation, const StoredFunction& stored, const float* theta,
                      const CheckOptions& options);
  // The bare tent, which needs no theta. Sums of the blend are asked only where the tent is not all that a lit point has: they would
  // weigh the rounding of bytes.
  FunctionCheck checkBareTent(const StoredFunction& stored, const CheckOptions& options);

  // Whether the function has less than its tent somewhere and is not 0 there: only then the check of its bare tent asks for sums.
  bool isPartlyLit(const StoredFunction& stored) const;

 private:
  FunctionCheck compare(const float* values, const StoredFunction& stored, const CheckOptions& options) const;

  AlignedFloats values_;       // P, pattern order
  AlignedFloats cell_values_;  // by place of a cell order
  AlignedFloats tent_;         // P, pattern order
  std::vector<uint8_t> tent_byte_;
};

}  // namespace nlg
