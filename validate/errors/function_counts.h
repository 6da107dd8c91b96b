// How many functions training and held-out shards hold together.
#pragma once

#include <string>
#include <vector>

#include "datagen/dataset/function_set.h"

namespace nlg {

struct FunctionCounts {
  ShardCounts all;                    // over all shards; a function that two of them hold is one function
  uint64_t held_out_in_training = 0;  // held-out functions that some training scene has too, by the rule for duplicates
};

// held_out_count   distinct functions of the held-out shards
FunctionCounts countFunctions(const std::vector<std::string>& training, const std::vector<std::string>& held_out,
                              uint64_t held_out_count);

}  // namespace nlg
