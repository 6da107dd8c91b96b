// The one policy from a weighting function to the theta that a light grid stores. Whoever bakes, or measures what a bake does, calls
// this: the bake, validation, error against run time, the hierarchy of truths, the stability suite, and engines from C++ and C.
//
//     bare tent, where it is enough → network → check → corrections → check → short fits → check → choice of representation
//     → refinement of what fails the check → rounding
//
// Which stages a representation goes through, and which functions take them, is a list (stagesOf); what became of every function is
// in its record. The check (function_check.h) alone decides whether a theta may stand for its function.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "runtime_eval/evaluator/generator.h"
#include "runtime_eval/fit/function_check.h"
#include "runtime_eval/fit/refinement.h"
#include "runtime_eval/fit/representation_choice.h"
#include "runtime_eval/fit/theta_batch.h"
#include "runtime_eval/fit/theta_stage.h"

namespace nlg {

class CompensatedRounding;

struct PolicyOptions {
  double bare_tent_rmse = 0.002;  // a function whose bare tent is not further off, and passes, has no theta; 0: every one has
  StageOptions stages;
  RefinementOptions refinement;  // with the check
  ChoiceOptions choice;          // among several representations
  ThetaPrecision theta_precision = ThetaPrecision::float32;

  const CheckOptions& check() const { return refinement.check; }
};

// The first number of the options that is not finite or not where policy_ranges.h says, by its name in the C interface
// ("refine_first_steps"); null where all of them are. What the classes below make of other options is not defined.
const char* outOfRange(const PolicyOptions& options);

// Whether a function has no theta: the check of its bare tent says so.
bool takesBareTent(const FunctionCheck& tent, const PolicyOptions& options);

// Whether a theta is good as it stands: what the network leaves so takes no other stage.
bool isGood(const FunctionCheck& theta, double good_rmse, const CheckOptions& check);

// What the list depends on beside the options.
struct StageFacts {
  Representation representation;
  bool exact_last_layer = false;  // the weights say that it is solved
  bool learned_steps = false;     // the weights hold them
  double tent_rmse = 0.0;         // of the network's theta for the bare tent: what it cannot do better for any function
};
StageFacts stageFacts(const Generator& generator);

// The stages of one representation in their order, the refinement last. What the options leave out is not there.
std::vector<StagePlan> stagesOf(const StageFacts& facts, const PolicyOptions& options);

// What became of one function in one representation.
struct ThetaRecord {
  std::array<FunctionCheck, kThetaWordCount> check;  // of theta, by ThetaWord
  std::array<float, kThetaWordCount> word_us{};      // what it took to come from the word before to this one, by the steady clock
  std::array<float, kThetaStageCount> stage_us{};    // the same by ThetaStage; of what runs in batches, a function's share
  ThetaStage ended = ThetaStage::network;            // that made theta what it is; bare_tent: there is none
  bool took_fit = false;                      // any step of Adam or Levenberg–Marquardt, kept or not, in any representation
  bool refined = false;                       // took the refinement …
  FitStop refinement_stop = FitStop::budget;  // … whose last fit ended so

  const FunctionCheck& at(ThetaWord word) const { return check[static_cast<size_t>(word)]; }
  FunctionCheck& at(ThetaWord word) { return check[static_cast<size_t>(word)]; }
  // From the function to this word.
  double elapsedUs(ThetaWord word) const;
};

// Copies of theta at the words before the last, for who measures them: count x D each. Of StageRunner and ThetaPolicy::make, fitted
// is before the refinement; of ThetaPolicy::bake, after it; where a larger
// representation was taken, that of the smallest before it.
struct ThetaTrace {
  std::vector<float> network, corrected, fitted;
};

// The stages of one representation before the refinement. One of these a thread and generator.
class StageRunner {
 public:
  // generator   must outlive it
  // last        no stage after this one runs
  StageRunner(const Generator& generator, const PolicyOptions& options, ThetaStage last = ThetaStage::adam);
  ~StageRunner();

  // The network's theta of functions and all that follows. Every function has the same theta whatever stands beside it.
  // theta     count x D, overwritten
  // records   count of them: checks of network, corrected and fitted; stored is as fitted
  // trace     may be null; grows by the functions
  void make(const StoredFunction* functions, int count, float* theta, ThetaRecord* records, ThetaTrace* trace = nullptr);
  // The same from theta that stand in the network's place. Allocates nothing without a trace.
  void improve(const StoredFunction* functions, int count, float* theta, ThetaRecord* records, ThetaTrace* trace = nullptr);

  const std::vector<StagePlan>& plan() const { return plan_; }
  FunctionChecker& checker() { return checker_; }

 private:
  struct Stage {
    StagePlan plan;
    std::unique_ptr<StageRun> run;
  };

  void runBatch(const StoredFunction* functions, int count, float* theta, ThetaRecord* records, bool generates,
                ThetaTrace* trace);
  void runStage(Stage& stage, ThetaRecord* records);
  // Checks what has changed since the word before; a theta that passed and would no longer is put back.
  void finishWord(ThetaWord word, const StoredFunction* functions, ThetaRecord* records);
  void checkAll(const StoredFunction* functions, ThetaRecord* records);

  PolicyOptions options_;
  std::vector<StagePlan> plan_;
  std::vector<Stage> stages_;
  ThetaBatch batch_;
  FunctionChecker checker_;
  std::vector<int> wrong_, members_;    // indices into the batch
  std::vector<float> kept_;             // theta of the word before …
  std::vector<ThetaStage> kept_ended_;  // … and the stages that made them
  std::vector<double> before_;          // mean squares before a stage
};

// What a function has come to.
struct MadeTheta {
  uint8_t generator = 0;    // index of the one whose representation stands for it
  bool larger_ran = false;  // whether more than the smallest representation was tried
  Theta theta;              // empty where the bare tent is enough
  ThetaRecord
      record;  // of the representation that was chosen (where refinement took a larger one, fitted and stored are of that);
               // times and took_fit are of all that were tried

  bool isBareTent() const { return record.ended == ThetaStage::bare_tent; }
  const FunctionCheck& check() const { return record.at(ThetaWord::stored); }
};

// One of these a thread.
class ThetaPolicy {
 public:
  // generators   one a representation, by rising D; at least one, at most 256; they must outlive it
  // last         no stage after this one runs
  ThetaPolicy(std::vector<const Generator*> generators, const PolicyOptions& options, ThetaStage last = ThetaStage::rounding);
  ~ThetaPolicy();

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
  // What rounding makes of theta: the least troubled of several ways, where one is enough.
  struct Rounded {
    Theta theta;
    FunctionCheck check;
  };
  Rounded roundOnce(const StoredFunction& function, const MadeTheta& made);
  Rounded roundToHalves(const StoredFunction& function, const MadeTheta& made);
  Rounded roundToBytes(const StoredFunction& function, const MadeTheta& made);
  Theta theta0(size_t generator) const;
  Theta startOfLarger(const StoredFunction& function, size_t generator, const MadeTheta& present);

  std::vector<const Generator*> generators_;
  PolicyOptions options_;
  ThetaStage last_;
  std::vector<std::unique_ptr<StageRunner>> runners_;  // by generator
  Refiner refiner_;
  std::unique_ptr<CompensatedRounding> compensated_;  // for int8 alone: it holds half a megabyte
  FunctionChecker checker_;
};

}  // namespace nlg
