// Points of fits at growing budgets: from the corrected theta, from theta0, and from a random start.
#pragma once

#include "validate/frontier/timed_policy.h"

namespace nlg {

// Steps, each list rising.
struct FitBudgets {
  // of Adam, product fields and codes take a 32nd: each of their steps reads all points
  std::vector<int> lm, adam;                // from the corrected theta
  std::vector<int> direct_lm, direct_adam;  // from theta0; Adam from a random start as well, and LM of a code
};

// Families lm_from_corrected and adam_from_corrected, whose time holds all that comes before the fit.
std::vector<PlotRun> fitsOfCorrected(const std::shared_ptr<const Generator>& generator, const PolicyOptions& options,
                                     const FitBudgets& budgets);

// The baselines of a generator, which minimise the policy's own loss. Families lm_from_theta0, adam_from_theta0 and adam_from_random fit
// every function, each budget from the start; of codes, whose theta0 is the mean code, lm_from_random does too. Beside each stands a
// family …_gated, under the policy's own gate: rounds of the same budgets, each from where the one before ended, for functions that
// fail the check or whose blend RMSE is above the one above which the policy takes its last fit before the refinement.
// seed   of the random starts; every function has one of its own, the same for all budgets
std::vector<PlotRun> directFits(const std::shared_ptr<const Generator>& generator, const PolicyOptions& options,
                                const FitBudgets& budgets, uint64_t seed);

}  // namespace nlg
