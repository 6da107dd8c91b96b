// Runs the stages of one representation up to the refinement, on batches of functions.
#pragma once

#include <chrono>
#include <memory>
#include <vector>

#include "runtime_eval/policy/stage_plan.h"
#include "runtime_eval/policy/theta_batch.h"

namespace nlg {

// For measurements: copies of theta at the words before the last: count x D each, of the functions that take a theta, in their order. Where a larger
// representation was taken, they are of the smallest.
struct ThetaTrace {
  std::vector<float> network, corrected;
  std::vector<float> fitted;  // of StageRunner and ThetaPolicy::make, before the refinement; of ThetaPolicy::bake, after it
};

inline float microsecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<float, std::micro>(std::chrono::steady_clock::now() - start).count();
}

// A stage between the network and the refinement; null of others, which are the policy's own.
std::unique_ptr<StageRun> makeStage(const StagePlan& plan, const Generator& generator);

// One of these a thread and generator. Without a trace it allocates nothing, once it is made.
class StageRunner {
 public:
  // generator   must outlive it
  // last        no stage after this one runs
  StageRunner(const Generator& generator, const PolicyOptions& options, ThetaStage last = ThetaStage::adam);

  // The network's theta of functions and all that follows. Every function has the same theta whatever stands beside it.
  // theta     count x D, overwritten
  // records   count of them: checks of network, corrected and fitted; stored is as fitted
  // trace     may be null; grows by the functions
  void make(const StoredFunction* functions, int count, float* theta, ThetaRecord* records, ThetaTrace* trace = nullptr);

  const std::vector<StagePlan>& plan() const { return plan_; }

 private:
  struct Stage {
    StagePlan plan;
    std::unique_ptr<StageRun> run;
  };

  void makeBatch(const StoredFunction* functions, int count, float* theta, ThetaRecord* records, ThetaTrace* trace);
  void runStage(Stage& stage, ThetaRecord* records);
  // Checks what has changed since the word before; a theta that passed and would no longer is put back.
  void finishWord(ThetaWord word, const StoredFunction* functions, ThetaRecord* records);
  void checkNetwork(const StoredFunction* functions, ThetaRecord* records);

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

}  // namespace nlg
