// The policy: from a weighting function to the theta that a light grid stores. The bake, validation and every measurement call this one.
//
//     bare tent, where it is enough → network → check → exact last layer → check → short fit → check → choice of representation
//     → refinement of what fails the check → rounding
//
// ThetaStage names the stages, ThetaRecord holds what became of a function. The check (check.h) alone decides whether a theta may stand for
// its function.
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

// Defaults, ranges and what each option means: policy_options.def. The settings of the tools and the fields of C have the same names.
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

  // The same choice on the errors of predicted theta, which have further to fall.
  ChoiceOptions forPredicted() const { return {choice_flat_ratio, choice_enough_rmse * choice_generator_excess, 1.0}; }
};

struct PolicyOptions : StageOptions, CodeOptions, CheckOptions, RefinementOptions, ChoiceOptions {
  ThetaPrecision theta_precision = ThetaPrecision::int8;  // what stored theta are rounded to, as a light grid holds them

  const CheckOptions& check() const { return *this; }
  CheckOptions& check() { return *this; }
};

// The name of the first option that is not finite or not in its range, "refine_first_steps"; null where all of them are. What the policy
// makes of other options is not defined.
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
  larger,      // the same for the next larger representation
  rounding,    // to the light grid's precision
  check,       // whether theta may stand for its function: after each of the words below
};
inline constexpr int kThetaStageCount = 10;

// What every table sums stages up to: *network* (one pass of the generator's network), *corrected* (and the last layer solved exactly),
// *fitted* (and any step of Adam or Levenberg–Marquardt), *stored* (what the grid holds).
enum class ThetaWord : uint8_t { network, corrected, fitted, stored };
inline constexpr int kThetaWordCount = 4;

// "exact last layer"; a key for files: "last_layer"; "corrected".
const char* stageTitle(ThetaStage stage);
const char* stageName(ThetaStage stage);
const char* wordName(ThetaWord word);
// The word that theta has earned with this stage; rounding and bare tents: stored. Not of `check`.
ThetaWord wordOf(ThetaStage stage);
// Whether it takes steps of Adam or Levenberg–Marquardt.
bool isFit(ThetaStage stage);

// Why a fit ended.
enum class FitStop {
  budget,      // all steps taken
  gradient,    // the gradient vanished
  progress,    // steps stopped paying
  damping,     // no damping made a step downhill (a minimum, or numbers at their end)
  no_points,   // no valid point: theta returned as it was given
  not_finite,  // start or function not finite: theta returned as it was given
};
inline constexpr int kFitStopCount = 6;
const char* fitStopName(FitStop stop);

// What became of one function in one representation.
struct ThetaRecord {
  std::array<FunctionCheck, kThetaWordCount> check;  // of theta, by ThetaWord
  std::array<float, kThetaWordCount> word_us{};      // microseconds from the word before to this one, by the steady clock
  std::array<float, kThetaStageCount> stage_us{};    // the same by ThetaStage; of what runs in batches, a function's share
  ThetaStage ended = ThetaStage::network;            // that made theta what it is; bare_tent: there is none
  bool took_fit = false;                      // any step of Adam or Levenberg–Marquardt, kept or not, in any representation
  bool refined = false;                       // took the refinement
  FitStop refinement_stop = FitStop::budget;  // why its last fit ended

  const FunctionCheck& at(ThetaWord word) const { return check[static_cast<size_t>(word)]; }
  FunctionCheck& at(ThetaWord word) { return check[static_cast<size_t>(word)]; }
  void addTime(ThetaStage stage, ThetaWord word, float elapsed_us) {
    stage_us[static_cast<size_t>(stage)] += elapsed_us;
    word_us[static_cast<size_t>(word)] += elapsed_us;
  }
  // Microseconds from the function to this word.
  double elapsedUs(ThetaWord word) const {
    return std::accumulate(word_us.begin(), word_us.begin() + static_cast<ptrdiff_t>(word) + 1, 0.0);
  }
};

// Whether a function has no theta: the check of its bare tent says so.
bool takesBareTent(const FunctionCheck& tent, const PolicyOptions& options);

// What the policy made of a function.
struct MadeTheta {
  uint8_t generator = 0;    // index of the one whose representation stands for it
  bool larger_ran = false;  // whether more than the smallest representation was tried
  Theta theta;              // D floats; empty where the bare tent is enough
  // Of the representation that was chosen; where refinement took a larger one, fitted and stored are of that. Times and took_fit are of
  // all that were tried.
  ThetaRecord record;

  bool isBareTent() const { return record.ended == ThetaStage::bare_tent; }
  const FunctionCheck& check() const { return record.at(ThetaWord::stored); }
};

struct StagePlan;   // runtime_eval/policy/stage_plan.h
struct ThetaTrace;  // runtime_eval/policy/theta_trace.h

// One of these a thread.
class ThetaPolicy {
 public:
  // generators   one a representation, by rising D; 1 to 256 of them; they must outlive the policy
  // options      in their ranges (outOfRange)
  // last         no stage after this one runs
  ThetaPolicy(std::vector<const Generator*> generators, const PolicyOptions& options, ThetaStage last = ThetaStage::rounding);
  ~ThetaPolicy();
  ThetaPolicy(ThetaPolicy&&) noexcept;
  ThetaPolicy& operator=(ThetaPolicy&&) noexcept;

  const PolicyOptions& options() const;
  const std::vector<StagePlan>& plan(size_t generator) const;

  // All stages. A function's theta does not depend on the functions beside it. Fastest with thousands of functions a call.
  // made     count of them, overwritten
  // trace    for measurements; may be null
  void bake(const StoredFunction* functions, int count, MadeTheta* made, ThetaTrace* trace = nullptr);

  // The same in parts, for a bake that refines the worst functions first: checkBareTent and takesBareTent, make, refine, round.
  FunctionCheck checkBareTent(const StoredFunction& function);
  // Network, exact last layer, short fits and the choice of representation.
  void make(const StoredFunction* functions, int count, MadeTheta* made, ThetaTrace* trace = nullptr);
  // Where the check fails: fits on, in the next larger representation where this one is not enough.
  void refine(const StoredFunction& function, MadeTheta* made);
  // Rounds to theta_precision; a number beyond float16 becomes the largest that it has. The check of the result is recorded. Where a theta
  // that passed would fail now, it is fitted to a stricter check and rounded again.
  void round(const StoredFunction& function, MadeTheta* made);

 private:
  struct Stages;
  std::unique_ptr<Stages> stages_;
};

}  // namespace nlg
