// Functions that need no theta of their own, since that of another may stand for them: levels repeat themselves.
//
// Which one may is decided against the samples of the function itself, never against its theta: two that differ little may differ where
// the function is 0, and whoever took the other's would leak.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "runtime_eval/evaluator/generator.h"
#include "runtime_eval/fit/theta_policy.h"

namespace nlg {

struct SharedThetas {
  std::vector<uint32_t> whose;       // by function: whose theta stands for it, which is its own in that other's place
  std::vector<FunctionCheck> check;  // by function: of the theta that stands for it
  uint64_t count = 0;                // functions that another's stands for
};

// The samples of a function, held by `samples`; any thread may ask.
using ReadFunction = std::function<StoredFunction(uint64_t function, std::vector<uint8_t>* samples)>;

// Another's theta may stand for a function where it passes the check, or is in no more trouble than the function's own; and where its
// RMSE, with dark points weighed as in fits, is no larger than share_rmse, or than that of its own. Of many, those stay that may stand
// for most. The same for any number of threads.
//
// made         by function: rounded to what is stored, none of them a bare tent
// generators   of their representations
SharedThetas shareThetas(const std::vector<MadeTheta>& made, const std::vector<Generator>& generators, const ReadFunction& read,
                         const CheckOptions& options, double share_rmse, int thread_count);

}  // namespace nlg
