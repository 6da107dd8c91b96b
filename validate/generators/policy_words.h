// Runs the bake's policy for one generator on every held-out function, and measures it at each of the four words.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "runtime_eval/evaluator/generator/projection.h"
#include "runtime_eval/policy/stage_plan.h"
#include "validate/generators/measured_word.h"

namespace nlg {

// The policy on many functions, on all threads, as a bake runs it: bare tents, batches through the stages, refinement, rounding.
//
// Validation calls ThetaPolicy::bake, a bake calls its parts. bake_equals_validation_test.cpp tests that both come to the same theta,
// bit for bit, whatever the batches and threads.
struct PolicyRunOptions {
  int threads = 1;
  int batch = kBatchCount;  // functions that a thread takes at once
};

// D floats at every word; null where the function takes no theta.
using ThetaByWord = std::array<const float*, kThetaWordCount>;

// What is told of every function once it is done; on any thread, functions in any order. theta last until it returns. With several
// generators only `stored` is there.
using UseTheta = std::function<void(int thread, uint64_t function, const MadeTheta& made, const ThetaByWord& theta)>;

// generators   as ThetaPolicy takes them
// returns      by function
std::vector<MadeTheta> runPolicy(const std::vector<const Generator*>& generators, const std::vector<StoredFunction>& functions,
                                 const PolicyOptions& policy, const PolicyRunOptions& options, const UseTheta& use = {});

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
