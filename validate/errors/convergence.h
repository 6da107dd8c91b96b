// Whether direct optimisation has converged: its error on hard functions with more random starts, and with fewer and more steps.
#pragma once

#include <vector>

#include "runtime_eval/evaluator/generator.h"
#include "validate/errors/best_known.h"

namespace nlg {

// Mean blend RMSE over the same functions of the best of all fits, at one setting.
struct ConvergencePoint {
  int restarts = 0;
  int adam_steps = 0;
  double blend_rmse_mean = 0.0;
};

struct Convergence {
  uint64_t functions = 0;
  std::vector<ConvergencePoint> by_restarts;  // 0 … twice those of direct, at its steps
  std::vector<ConvergencePoint> by_steps;     // a quarter, half, all, twice those of direct, at its restarts
  double best_known_blend_rmse_mean = 0.0;    // of the same functions: what the sample's ratios are taken to
};

// fits   of the sample
Convergence measureConvergence(const Generator& generator, const FunctionSet& set, const Populations& populations,
                               const LongFits& fits, const ValidateOptions& options);

}  // namespace nlg
