// One generator on every held-out function: what the bake's policy makes of it, measured at each of the four words.
#pragma once

#include <vector>

#include "runtime_eval/fit/theta_policy.h"
#include "validate/errors/measured_word.h"

namespace nlg {

struct PolicyWords {
  std::vector<StagePlan> plan;      // what its representation goes through
  std::vector<MeasuredWord> words;  // by ThetaWord, on all functions of the set
  std::vector<MadeTheta> made;      // by function: what a grid would store
  std::vector<Theta>
      least_wrong;  // by function of the sample: theta before rounding or after it, whichever has the lower blend RMSE

  const MeasuredWord& at(ThetaWord word) const { return words[static_cast<size_t>(word)]; }
};

// throws   NumericalError when an error is not finite, or as runPolicy does
PolicyWords measurePolicy(const Generator& generator, const FunctionSet& set, const Populations& populations,
                          const ValidateOptions& options);

// Time of evaluating a theta at the 8192 support points, µs: the median of many repeats on one thread.
double measureEvaluation(const Representation& representation);

std::vector<StoredFunction> storedFunctions(const FunctionSet& set);

}  // namespace nlg
