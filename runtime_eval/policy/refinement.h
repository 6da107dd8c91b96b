// The refinement: fits a theta that fails the check further, the worst functions first.
//
// Rounds of Adam (product fields: Levenberg–Marquardt), each longer than the one before, until the check passes: most functions
// pass after the first. What still fails is tried from theta0 too, a network from random starts and a field from coarse to fine as
// well: before the last round, which goes on from the best of them, or at the end where a round ended on its own. Why Adam and not
// Levenberg–Marquardt: docs/lab/measurements.md; why these numbers: docs/lab/training.md.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime_eval/fit/adam.h"
#include "runtime_eval/fit/levenberg_marquardt.h"

namespace nlg {

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
  // theta0   of the other starts: for a start that is broken or stuck. May be empty
  RefinementResult refine(const Representation& representation, const StoredFunction& stored, const Theta& start,
                          const Theta& theta0, const CheckOptions& check, const RefinementOptions& options);

 private:
  FitResult fitOn(const Representation& representation, const WeightingFunction& function, const Theta& start, int steps);

  FunctionChecker checker_;
  NormalEquationsKernel kernel_;
};

// The functions whose check failed, most trouble first; of two in equal trouble the one with the lower index.
std::vector<uint32_t> worstFirst(const std::vector<FunctionCheck>& checks, const CheckOptions& options);

}  // namespace nlg
