// The result of every fit.
#pragma once

#include <chrono>

#include "nlg/policy.h"
#include "runtime_eval/support/weighting_function.h"

namespace nlg {

struct FitResult {
  Theta theta;
  double rmse = 0.0;  // blend RMSE over all valid support points; never above that of the start that the fit was given
  int steps = 0;
  FitStop stop = FitStop::budget;
  double elapsed_us = 0.0;  // of this fit, by the steady clock
};

// Runs a fit and notes how long it took.
template <class Fit>
FitResult timedFit(const Fit& fit) {
  const auto start = std::chrono::steady_clock::now();
  FitResult result = fit();
  result.elapsed_us = std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
  return result;
}

// The blend RMSE: root of the mean over valid points of (mask (representation - phi))²; 0 when no point is valid; not finite when
// theta is not.
double functionRmse(const Representation& representation, const WeightingFunction& function, const float* theta);

}  // namespace nlg
