// The check: whether a theta may stand for its weighting function (the talk: "if the error is too high …").
#pragma once

#include <memory>

#include "nlg/representation.h"
#include "nlg/support.h"

namespace nlg {

// Defaults, ranges and what each option means: policy_options.def.
struct CheckOptions {
#define NLG_CHECK_OPTION(type, name, value, low, high, help) type name = value;
#include "nlg/policy_options.def"

  LossOptions loss() const { return {dark_weight, blend_floor}; }
};

// One theta against one function, over all valid support points. Leaks are counted at all valid points whose phi is stored as 0; the probe
// does see a few of them, at the tent's rim.
struct FunctionCheck {
  double rmse = 0.0;        // 0 when no point is valid; not finite, whatever the points, when theta is not
  double blend_rmse = 0.0;  // likewise, the root of the loss: what fits minimise; of two theta the lower one wins
  double leak_mean = 0.0;   // mean |value| over valid points whose phi is stored as 0; 0 when there are none
  double leak_share = 0.0;  // share of them with |value| above tau_leak of the tent and what a byte's rounding hides
  int valid_count = 0;
  int zero_count = 0;  // valid points whose phi is stored as 0

  bool passes(const CheckOptions& options) const { return trouble(options) <= 1.0; }
  // The larger of rmse / tau_rmse and blend_rmse / tau_blend; infinite when theta is not finite. Above 1 the check fails.
  double trouble(const CheckOptions& options) const;
};

// One of these a thread: it keeps 0.1 MB of working memory, so that a check allocates nothing.
class FunctionChecker {
 public:
  FunctionChecker();
  ~FunctionChecker();
  FunctionChecker(FunctionChecker&&) noexcept;
  FunctionChecker& operator=(FunctionChecker&&) noexcept;

  // theta   D floats
  FunctionCheck check(const Representation& representation, const StoredFunction& stored, const float* theta,
                      const CheckOptions& options);
  // The bare tent, which needs no theta. Its loss weighs lit points by 1 / S² only where the function has less than its tent somewhere and
  // is not 0 there: elsewhere the weight would act on the rounding of bytes alone.
  FunctionCheck checkBareTent(const StoredFunction& stored, const CheckOptions& options);

  // Whether the function has less than its tent somewhere and is not 0 there: only then checkBareTent reads blend_sum.
  bool isPartlyLit(const StoredFunction& stored) const;

 private:
  struct Buffers;
  FunctionCheck compare(const float* values, const StoredFunction& stored, const CheckOptions& options) const;

  std::unique_ptr<Buffers> buffers_;
};

}  // namespace nlg
