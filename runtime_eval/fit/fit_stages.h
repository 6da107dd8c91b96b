// Short fits after the corrections: Levenberg–Marquardt where an iteration is cheap, Adam elsewhere. They are direct optimisation
// from a good start, so that every function that takes one counts as fitted.
#pragma once

#include <vector>

#include "runtime_eval/fit/adam.h"
#include "runtime_eval/fit/levenberg_marquardt.h"
#include "runtime_eval/fit/theta_batch.h"
#include "runtime_eval/fit/theta_stage.h"

namespace nlg {

// Product fields, whose normal equations are a band, and networks of at most 32 numbers: there an iteration of
// Levenberg–Marquardt costs no more than a learned step and gains more. For others it costs half a millisecond.
bool iteratesCheaply(const Representation& representation);

class LevenbergMarquardtStage : public StageRun {
 public:
  enum class Start { theta, theta0 };
  LevenbergMarquardtStage(const Generator& generator, Start start, int iterations);
  void run(ThetaBatch& batch, int* members, int member_count) override;

 private:
  Start start_;
  LevenbergMarquardtOptions options_;
  NormalEquationsKernel kernel_;
  LevenbergMarquardtWorkspace workspace_;
  std::vector<float> theta_;  // one function
};

class AdamStage : public StageRun {
 public:
  // full_steps   of a function whose RMSE is .01; of others in proportion, four times as many at most
  AdamStage(const Generator& generator, int full_steps);
  void run(ThetaBatch& batch, int* members, int member_count) override;

 private:
  int full_steps_;
  AdamOptions options_;
  AdamWorkspace workspace_;
  SymmetricBand last_layer_;
  std::vector<float> theta_, other_;  // one function
};

}  // namespace nlg
