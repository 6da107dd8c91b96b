// The error of one theta against one function, measured every way that the report shows.
#pragma once

#include "datagen/dataset/function_set.h"
#include "runtime_eval/evaluator/evaluate.h"
#include "runtime_eval/support/loss_weights.h"
#include "runtime_eval/support/weighting_function.h"
#include "validate/errors/statistics.h"

namespace nlg {

struct FunctionError {
  double blend_rmse = 0;  // over valid support points, the root of the loss: what fits minimise, and what errors are judged by
  double rmse = 0;        // over the same points, all of which count alike
  double rmse_test_points = 0;  // over valid test points, which no fit has seen, and of which no S is known
  double rmse_occluded = 0;     // over valid support points that the probe does not see; 0 when there are none
  bool has_occluded = false;
  double leak_mean = 0;  // mean |value| over occluded points whose phi is stored as 0; 0 when there are none
  double leak_p99 = 0;   // 99th percentile of the same
};

// Points that all functions of a set share, prepared once. One of these a thread.
//
// A leak is weight where the probe does not see and where phi is 0. FunctionCheck does not know what the probe sees, and counts every
// valid point whose phi is stored as 0; a twentieth of these it does see, at the tent's rim, where the tent rounds to 0.
class ErrorMeter {
 public:
  // loss   that blend RMSEs are of: the policy's
  ErrorMeter(const FunctionSet& set, const LossOptions& loss);

  // index   function of the set
  FunctionError measure(const Representation& representation, const float* theta, uint64_t index);

  // The same for the bare tent, no network at all.
  FunctionError measureTent(uint64_t index);

  // |value| at every point that counted for leaks in what was measured last.
  const std::vector<double>& leakMagnitudes() const { return leak_magnitudes_; }

 private:
  FunctionError compare(const float* values, const float* test_values, uint64_t index);

  const FunctionSet& set_;
  LossWeights weights_;
  PointSet points_, test_points_;  // pattern order
  AlignedFloats values_, test_values_;
  std::vector<double> leak_magnitudes_, sorted_;
};

}  // namespace nlg
