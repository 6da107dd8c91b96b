// Runs the policy on blocks of functions up to any stage, timed.
#pragma once

#include <memory>

#include "validate/frontier/interleaved.h"

namespace nlg {

class TimedPolicy {
 public:
  // last   no stage after this one runs; with `rounding` theta are rounded as a bake stores them, to int8
  TimedPolicy(std::shared_ptr<const Generator> generator, const PolicyOptions& options, ThetaStage last);

  // theta of functions that take one. The policy's time on the block is shared out among them as its record says.
  std::vector<FittedFunction> run(const FunctionBlock& block);

 private:
  std::shared_ptr<const Generator> generator_;
  ThetaStage last_;
  ThetaPolicy policy_;
  std::vector<MadeTheta> made_;  // one block
};

// Points of the policy, family stages: after each stage of a representation's list, and theta rounded to int8, as a bake stores it,
// after the last. The last point of a word is named by it: network, corrected, fitted, stored.
std::vector<PlotRun> stagePoints(const std::shared_ptr<const Generator>& generator, const PolicyOptions& options);

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
