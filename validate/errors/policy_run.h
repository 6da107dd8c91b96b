// The policy on many functions, on all threads, as a bake runs it: bare tents, batches through the stages, refinement, rounding.
//
// Validation calls ThetaPolicy::bake, a bake calls its parts. bake_equals_validation_test.cpp tests that both come to the same theta,
// bit for bit, whatever the batches and threads.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "runtime_eval/fit/theta_policy.h"

namespace nlg {

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

}  // namespace nlg
