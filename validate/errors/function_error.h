// The error of one theta against one function, measured every way that the report shows.
#pragma once

#include "datagen/dataset/function_set.h"
#include "runtime_eval/evaluator/evaluate.h"
#include "runtime_eval/support/weighting_function.h"
#include "validate/errors/statistics.h"

namespace nlg {

struct FunctionError {
  double rmse = 0;         // over valid support points: what fits minimise
  double rmse_unseen = 0;  // over valid points that no fit sees
  double rmse_shadow = 0;  // over valid support points that the probe does not see; 0 when there are none
  bool has_shadow = false;
  double leak_mean = 0;  // mean |value| over valid support points whose phi is stored as 0
  double leak_p99 = 0;   // 99th percentile of the same
};

// Points that all functions of a set share, prepared once.
class ErrorMeter {
 public:
  explicit ErrorMeter(const FunctionSet& set);

  // index         function of the set
  // leaks         collects |value| at every valid point whose phi is 0; may be null
  FunctionError measure(const Representation& representation, const float* theta, uint64_t index, PooledMagnitudes* leaks);

  // The same for the bare tent, no network at all.
  FunctionError measureTent(uint64_t index, PooledMagnitudes* leaks);

 private:
  FunctionError compare(const float* values, const float* unseen_values, uint64_t index, PooledMagnitudes* leaks);

  const FunctionSet& set_;
  PointSet points_, unseen_points_;  // pattern order
  AlignedFloats values_, unseen_values_;
  std::vector<double> zero_point_values_;
};

}  // namespace nlg
