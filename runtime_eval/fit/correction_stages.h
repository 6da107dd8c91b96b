// Corrections: what a generator can still do about a theta that is wrong about its function, without any iterative fit, in tens of
// microseconds to a millisecond. docs/theory/math.md §6; what each setting costs and gives: docs/lab/training.md.
#pragma once

#include <vector>

#include "runtime_eval/fit/symmetric_band.h"
#include "runtime_eval/fit/theta_batch.h"
#include "runtime_eval/fit/theta_stage.h"

namespace nlg {

// Solves the last layer exactly, for networks with a linear output whose weights say so.
class LastLayerStage : public StageRun {
 public:
  explicit LastLayerStage(const Generator& generator);
  void run(ThetaBatch& batch, int* members, int member_count) override;

 private:
  SymmetricBand equations_;
  std::vector<float> solved_;
};

// Attempts at functions by learned steps: a small network sees theta, how wrong it is on its function and which way is down, and
// says how theta should change. Functions go on as long as that pays.
class LearnedStepsStage : public StageRun {
 public:
  // most_steps   0: attempts only solve the last layer and measure
  LearnedStepsStage(const Generator& generator, int most_steps);
  void run(ThetaBatch& batch, int* members, int member_count) override;

  // An attempt at mirror images of functions, which the network has just generated: last layers are solved, then steps follow.
  // start   member_count x D
  void attempt(ThetaBatch& batch, int mirror, const float* start, int* members, int member_count);

 private:
  void measure(ThetaBatch& batch, int mirror, bool solve, bool network_runs);
  void writeFeatures(const ThetaBatch& batch, int n, int mirror);
  // Offers what became better and closes up those for which the last step paid.
  void keepBetter(ThetaBatch& batch, int mirror);
  void goOn(ThetaBatch& batch, int mirror, bool solve_first);

  const Generator* generator_;
  int most_steps_;
  CorrectionFeatures places_;
  LayerScratch layer_scratch_;
  SymmetricBand equations_;
  // by member that goes on, one behind another
  int* going_on_ = nullptr;
  int count_ = 0;
  std::vector<float> current_, change_;      // count x D
  std::vector<double> error_, least_error_;  // of current_; least of this attempt
  std::vector<float> gradient_, theta_;      // one function
};

// Tries functions that are still wrong again as their mirror images: to the generator each is another function, with another
// theta and other mistakes, and theta mirrors back exactly.
class MirrorImagesStage : public StageRun {
 public:
  // attempts   1 … 8, the function itself included, which others have seen to
  MirrorImagesStage(const Generator& generator, int attempts, double above_rmse, int most_steps);
  void run(ThetaBatch& batch, int* members, int member_count) override;

 private:
  int attempts_;
  double above_square_;
  LearnedStepsStage steps_;
  std::vector<float> start_;
  std::vector<int> going_on_;
};

}  // namespace nlg
