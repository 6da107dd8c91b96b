// The check: measures one theta against its weighting function, and decides whether it is good enough to be stored.
//
//     FunctionChecker checker;  // one per thread
//     if (checker.check(representation, function, theta, {}).passes({})) store(theta);  // {}: the default options
//
// Nothing here throws but for memory, and a check allocates nothing.
#pragma once

#include <memory>

#include "nlg/representation.h"
#include "nlg/support.h"

namespace nlg {

// Options of the check and of the loss: meaning, default and range of each are in policy_options.def (tau_rmse 0.02, tau_blend
// 0.03).
struct CheckOptions {
#define NLG_CHECK_OPTION(type, name, value, low, high, help) type name = value;
#include "nlg/policy_options.def"

  LossOptions loss() const { return {dark_weight, blend_floor}; }
};

// Errors of one theta against one function, over all valid support points. Leaks are counted at valid points whose phi is stored
// as 0; a few of these the probe does see, at the tent's rim.
struct FunctionCheck {
  double rmse = 0.0;        // in units of phi, as 0.004; 0 if no point is valid; not finite if theta is not
  double blend_rmse = 0.0;  // root of the loss, which fits minimise; the lower one of two theta is the better; limits as of rmse
  double leak_mean = 0.0;   // mean |value| over valid points whose phi is stored as 0; 0 if there are none
  double leak_share = 0.0;  // share of these points with |value| above tau_leak of the tent, plus the rounding of phi to bytes
  int valid_count = 0;
  int zero_count = 0;  // valid points whose phi is stored as 0

  bool passes(const CheckOptions& options) const { return trouble(options) <= 1.0; }
  // Returns the larger of rmse / tau_rmse and blend_rmse / tau_blend. Above 1 the check fails; infinite if theta is not finite.
  double trouble(const CheckOptions& options) const;
};

// Working memory of the check, 0.1 MB. Each thread needs its own.
class FunctionChecker {
 public:
  FunctionChecker();
  ~FunctionChecker();
  FunctionChecker(FunctionChecker&&) noexcept;
  FunctionChecker& operator=(FunctionChecker&&) noexcept;

  // Returns the errors of theta.
  //
  // representation   what theta is of, as Generator::representation()
  // stored           the function: 8192 samples with their validity (support.h)
  // theta            D floats
  FunctionCheck check(const Representation& representation, const StoredFunction& stored, const float* theta,
                      const CheckOptions& options);
  // Returns the errors of the bare tent, which needs no theta. Lit points are weighted by 1 / S² only for functions that are
  // below their tent, but not 0, somewhere: for others the weight would act only on the rounding of phi to bytes.
  FunctionCheck checkBareTent(const StoredFunction& stored, const CheckOptions& options);

  // Returns whether the function is below its tent, but not 0, somewhere. Only then checkBareTent reads blend_sum.
  bool isPartlyLit(const StoredFunction& stored) const;

 private:
  struct Buffers;
  FunctionCheck compare(const float* values, const StoredFunction& stored, const CheckOptions& options) const;

  std::unique_ptr<Buffers> buffers_;
};

}  // namespace nlg
