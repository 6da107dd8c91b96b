// The policy: computes from a weighting function the theta that a light grid stores. The bake and every measurement use this one.
//
//     bare tent, if it is good enough → network → check → exact last layer → check → short fit → check → choice of representation
//     → refinement of what fails the check → rounding
//
// ThetaStage names the stages, and ThetaRecord holds the result of each for one function. Only the check (check.h) decides
// whether a theta is good enough.
//
//     ThetaPolicy policy({&generator}, PolicyOptions{});  // one per thread
//     policy.bake(functions, count, made.data());         // made[i].theta: empty for a bare tent
//
// See examples/bake_minimal.cpp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <vector>

#include "nlg/check.h"
#include "nlg/generator.h"
#include "nlg/representation.h"
#include "nlg/support.h"

namespace nlg {

// Meaning, default and range of each option are in policy_options.def. Settings of the tools and fields of nlg.h have the same
// names.
struct StageOptions {
#define NLG_STAGE_OPTION(type, name, value, low, high, help) type name = value;
#include "nlg/policy_options.def"
};
struct CodeOptions {
#define NLG_CODE_OPTION(type, name, value, low, high, help) type name = value;
#include "nlg/policy_options.def"
};
struct RefinementOptions {
#define NLG_REFINEMENT_OPTION(type, name, value, low, high, help) type name = value;
#include "nlg/policy_options.def"
};
struct ChoiceOptions {
#define NLG_CHOICE_OPTION(type, name, value, low, high, help) type name = value;
#include "nlg/policy_options.def"

  // Returns the options of the same choice by errors of predicted theta, which fits still lower.
  ChoiceOptions forPredicted() const { return {choice_flat_ratio, choice_enough_rmse * choice_generator_excess, 1.0}; }
};

struct PolicyOptions : StageOptions, CodeOptions, CheckOptions, RefinementOptions, ChoiceOptions {
  ThetaPrecision theta_precision = ThetaPrecision::int8;  // number format that stored theta are rounded to

  const CheckOptions& check() const { return *this; }
  CheckOptions& check() { return *this; }
};

// Returns the name of the first option that is not finite or not in its range, as "refine_first_steps"; null if all are valid.
// With invalid options the policy is undefined.
const char* outOfRange(const PolicyOptions& options);

// The stages, in the order in which a function meets them.
enum class ThetaStage : uint8_t {
  bare_tent,   // no theta: the bare tent is enough
  network,     // one pass of the generator's network
  last_layer,  // the last layer solved exactly
  lm,          // Levenberg–Marquardt
  lm_theta0,   // Levenberg–Marquardt from theta0
  adam,        // a short run of Adam
  refinement,  // fits in rounds until the check passes
  larger,      // refinement in the next larger representation
  rounding,    // to the light grid's precision
  check,       // the check, after each of the words below
};
inline constexpr int kThetaStageCount = 10;

// Groups of stages, by which every table reports errors and times: *network*, one pass of the generator; *corrected*, with the
// last layer solved exactly; *fitted*, after all steps of Adam and Levenberg–Marquardt; *stored*, what the grid holds.
enum class ThetaWord : uint8_t { network, corrected, fitted, stored };
inline constexpr int kThetaWordCount = 4;

// Return the title of a stage ("exact last layer"), its key in files ("last_layer"), and the key of a word ("corrected").
const char* stageTitle(ThetaStage stage);
const char* stageName(ThetaStage stage);
const char* wordName(ThetaWord word);
// Returns the word that a stage belongs to; rounding and bare tents belong to stored. The stage must not be `check`.
ThetaWord wordOf(ThetaStage stage);
// Returns whether a stage takes steps of Adam or Levenberg–Marquardt.
bool isFit(ThetaStage stage);

// Why a fit ended.
enum class FitStop {
  budget,      // all steps taken
  gradient,    // the gradient vanished
  progress,    // steps lower the loss too little
  damping,     // no damping gives a step that lowers the loss: a minimum, or the precision of floats is reached
  no_points,   // no valid point: theta returned as it was given
  not_finite,  // start or function not finite: theta returned as it was given
};
inline constexpr int kFitStopCount = 6;
const char* fitStopName(FitStop stop);

// Result of every stage for one function in one representation.
struct ThetaRecord {
  std::array<FunctionCheck, kThetaWordCount> check;  // of theta, by ThetaWord
  std::array<float, kThetaWordCount> word_us{};      // time from the word before to this one, microseconds of a steady clock
  std::array<float, kThetaStageCount> stage_us{};    // time of each ThetaStage, microseconds; of a batch, the function's share
  ThetaStage ended = ThetaStage::network;            // last stage that changed theta; bare_tent: there is no theta
  bool took_fit = false;                      // any step of Adam or Levenberg–Marquardt, kept or not, in any representation
  bool refined = false;                       // whether the refinement ran
  FitStop refinement_stop = FitStop::budget;  // why the last fit of the refinement ended

  const FunctionCheck& at(ThetaWord word) const { return check[static_cast<size_t>(word)]; }
  FunctionCheck& at(ThetaWord word) { return check[static_cast<size_t>(word)]; }
  void addTime(ThetaStage stage, ThetaWord word, float elapsed_us) {
    stage_us[static_cast<size_t>(stage)] += elapsed_us;
    word_us[static_cast<size_t>(word)] += elapsed_us;
  }
  // Returns the time up to this word, microseconds.
  double elapsedUs(ThetaWord word) const {
    return std::accumulate(word_us.begin(), word_us.begin() + static_cast<ptrdiff_t>(word) + 1, 0.0);
  }
};

// Returns whether the bare tent is good enough, so that the function needs no theta.
// tent   result of checkBareTent
bool takesBareTent(const FunctionCheck& tent, const PolicyOptions& options);

// The policy's result for one function.
struct MadeTheta {
  uint8_t generator = 0;    // index of the generator whose representation was chosen
  bool larger_ran = false;  // whether more than the smallest representation was tried
  Theta theta;              // D floats; empty for a bare tent
  // Of the chosen representation; if refinement took a larger one, fitted and stored are of the larger one. Times and took_fit
  // cover all representations that were tried.
  ThetaRecord record;

  bool isBareTent() const { return record.ended == ThetaStage::bare_tent; }
  const FunctionCheck& check() const { return record.at(ThetaWord::stored); }
};

// Of this project's own measurements; their definitions are not installed.
struct StagePlan;   // runtime_eval/policy/stage_plan.h
struct ThetaTrace;  // runtime_eval/policy/stage_runner.h

// Runs the policy. Each thread needs its own.
class ThetaPolicy {
 public:
  // generators   1 to 256, one per representation, by rising D; they must outlive the policy
  // options      valid by outOfRange
  // last         the last stage that runs, as ThetaStage::network to measure predictions
  ThetaPolicy(std::vector<const Generator*> generators, const PolicyOptions& options, ThetaStage last = ThetaStage::rounding);
  ~ThetaPolicy();
  ThetaPolicy(ThetaPolicy&&) noexcept;
  ThetaPolicy& operator=(ThetaPolicy&&) noexcept;

  const PolicyOptions& options() const;
  const std::vector<StagePlan>& plan(size_t generator) const;

  // Runs all stages. The theta of a function does not depend on the other functions of the call. Fastest with thousands of
  // functions per call.
  //
  // functions   count functions
  // made        count results, overwritten
  // trace       of this project's own measurements; else null
  void bake(const StoredFunction* functions, int count, MadeTheta* made, ThetaTrace* trace = nullptr);

  // The parts of bake, for callers that refine the worst functions first: call checkBareTent, takesBareTent, make, refine, round,
  // in this order. checkBareTent returns the errors of the bare tent.
  FunctionCheck checkBareTent(const StoredFunction& function);
  // Runs network, exact last layer, short fits and the choice of representation.
  void make(const StoredFunction* functions, int count, MadeTheta* made, ThetaTrace* trace = nullptr);
  // Fits further if the check fails, in the next larger representation if this one does not suffice. Does nothing if the check
  // passes.
  void refine(const StoredFunction& function, MadeTheta* made);
  // Rounds theta to theta_precision and records its check; numbers beyond float16 become its largest. A theta that passed the
  // check, and fails after rounding, is fitted to a stricter check and rounded again.
  void round(const StoredFunction& function, MadeTheta* made);

 private:
  struct Stages;
  std::unique_ptr<Stages> stages_;
};

}  // namespace nlg
