// What a bake does with a theta that fails the check: fits on from it, the worst functions first.
//
// The policy is the talk's, with Levenberg–Marquardt beside Adam; which of them, and how long, was chosen by error against time:
// docs/measurements.md.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime_eval/fit/adam.h"
#include "runtime_eval/fit/function_check.h"
#include "runtime_eval/fit/levenberg_marquardt.h"

namespace nlg {

struct RefinementOptions {
  CheckOptions check;
  int iterations = 16;       // of Levenberg–Marquardt, a round
  int rounds = 2;            // a function that still fails is fitted on, its leaking points with more weight
  double leak_weight = 4.0;  // of points whose phi is 0 in later rounds, when leak is what fails
};

struct RefinementResult {
  Theta theta;
  FunctionCheck check;             // of theta
  FitStop stop = FitStop::budget;  // of the last fit
  int steps = 0;                   // over all rounds
};

// One of these a thread.
class Refiner {
 public:
  // Fits on from `start` until the check passes or the rounds are used up. The result is never in more trouble than the start.
  RefinementResult refine(const Representation& representation, const StoredFunction& stored, const Theta& start,
                          const RefinementOptions& options);

 private:
  FunctionChecker checker_;
  NormalEquationsKernel kernel_;
};

// The functions whose check failed, most trouble first; of two in equal trouble the one with the lower index.
std::vector<uint32_t> worstFirst(const std::vector<FunctionCheck>& checks, const CheckOptions& options);

}  // namespace nlg
