// The one policy from a weighting function to the theta that a light grid stores. Whoever bakes, or measures what a bake does, calls
// this: the bake, validation, error against run time, the hierarchy of truths, the stability suite, and engines from C++ and C.
//
//     bare tent, where it is enough → network → check → exact last layer → check → short fit → check → choice of representation
//     → refinement of what fails the check → rounding
//
// Which stages a representation goes through, and which functions take them, is a list (stage_plan.h). What became of a function is in
// its record (theta_record.h). The check (function_check.h) alone decides whether a theta may stand for its function.
#pragma once

#include <memory>
#include <vector>

#include "runtime_eval/fit/refinement.h"
#include "runtime_eval/fit/representation_choice.h"
#include "runtime_eval/fit/stage_runner.h"
#include "runtime_eval/fit/theta_rounding.h"

namespace nlg {

// Whether a function has no theta: the check of its bare tent says so.
bool takesBareTent(const FunctionCheck& tent, const PolicyOptions& options);

// What a function has come to.
struct MadeTheta {
  uint8_t generator = 0;    // index of the one whose representation stands for it
  bool larger_ran = false;  // whether more than the smallest representation was tried
  Theta theta;              // empty where the bare tent is enough
  // Of the representation that was chosen; where refinement took a larger one, fitted and stored are of that. Times and took_fit are of
  // all that were tried.
  ThetaRecord record;

  bool isBareTent() const { return record.ended == ThetaStage::bare_tent; }
  const FunctionCheck& check() const { return record.at(ThetaWord::stored); }
};

// One of these a thread.
class ThetaPolicy {
 public:
  // generators   one a representation, by rising D; at least one, at most 256; they must outlive it
  // last         no stage after this one runs
  ThetaPolicy(std::vector<const Generator*> generators, const PolicyOptions& options, ThetaStage last = ThetaStage::rounding);

  const PolicyOptions& options() const { return options_; }
  const std::vector<StagePlan>& plan(size_t generator) const { return runners_[generator]->plan(); }

  // All of it. Every function has the same theta whatever stands beside it.
  // made     count of them, overwritten
  // trace    theta of the functions that take one, in their order; of the smallest representation; may be null
  void bake(const StoredFunction* functions, int count, MadeTheta* made, ThetaTrace* trace = nullptr);

  // The same in its parts, for who bakes many at once and refines the worst first: takesBareTent, make, refine, round.
  FunctionCheck checkBareTent(const StoredFunction& function);
  // trace   of the smallest representation; may be null
  void make(const StoredFunction* functions, int count, MadeTheta* made, ThetaTrace* trace = nullptr);
  // Where the check fails: fits on, in the next larger representation where this one is not enough.
  void refine(const StoredFunction& function, MadeTheta* made);
  // To theta_precision; a number beyond float16 becomes the largest that it has. What the check finds of it is recorded. Where that
  // makes a theta fail that had passed, and there is a refinement, it fits on to less than the check asks for, and rounds again.
  void round(const StoredFunction& function, MadeTheta* made);

 private:
  Theta theta0(size_t generator) const;
  Theta startOfLarger(const StoredFunction& function, size_t generator, const MadeTheta& present);

  std::vector<const Generator*> generators_;
  PolicyOptions options_;
  ThetaStage last_;
  std::vector<std::unique_ptr<StageRunner>> runners_;  // by generator
  Refiner refiner_;
  ThetaRounding rounding_;
  FunctionChecker checker_;
};

}  // namespace nlg
