// Short fits after the correction: Levenberg–Marquardt for product fields, Adam for networks. A function that takes one counts
// as fitted.
#pragma once

#include <vector>

#include "nlg/policy.h"
#include "runtime_eval/fit/adam.h"
#include "runtime_eval/fit/levenberg_marquardt.h"
#include "runtime_eval/fit/symmetric_band.h"
#include "runtime_eval/policy/theta_batch.h"

namespace nlg {

// The correction: solves the last layer exactly for each function, in networks with a linear output whose weights ask for it.
// No iterative fit. docs/theory/math.md §6.
class LastLayerStage : public StageRun {
 public:
  // generator   with exactLastLayer()
  explicit LastLayerStage(const Generator& generator);
  void run(ThetaBatch& batch, const int* members, int member_count) override;

 private:
  SymmetricBand equations_;
  std::vector<float> solved_;
};

// For product fields, whose normal equations are a band, so that an iteration is cheap. Networks gain more by Adam in the same time,
// the smallest too (docs/lab/training.md).
class LevenbergMarquardtStage : public StageRun {
 public:
  enum class Start { theta, theta0 };
  LevenbergMarquardtStage(const Generator& generator, Start start, int iterations);
  void run(ThetaBatch& batch, const int* members, int member_count) override;

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
  void run(ThetaBatch& batch, const int* members, int member_count) override;

 private:
  int full_steps_;
  AdamOptions options_;
  AdamWorkspace workspace_;
  SymmetricBand last_layer_;
  std::vector<float> theta_;  // one function
};

}  // namespace nlg
