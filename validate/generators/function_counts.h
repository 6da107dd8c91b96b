// Counts the functions of training and held-out shards, and held-out ones that training shards hold too.
#pragma once

#include <string>
#include <vector>

#include "datagen/dataset/function_set.h"

namespace nlg {

// What every measurement of functions begins with: held-out functions, or an error that says what is wrong with them.
//
// The functions of held-out shards, with points that no fit sees.
// throws   InputError as readFunctionSet does; when there is no function at all, when the shards were made without --held-out, or
//          with another pattern of test points than this code's
FunctionSet readHeldOut(std::vector<std::string> paths);

struct FunctionCounts {
  ShardCounts all;       // over all shards; a function that two of them hold is one function
  KnownFunctions known;  // by held-out function: whether some training scene has it too, as it is or mirrored
};

// Reads every shard once. Without training shards nothing is known.
// set           the functions of the held-out shards
// thread_count  at least 1; more than three are of no use. Three shards are held at a time
// throws        InputError as readShard does, or when shards were made with different rules for duplicates; ThreadError
FunctionCounts countFunctions(const std::vector<std::string>& training, const std::vector<std::string>& held_out,
                              const FunctionSet& set, int thread_count);

}  // namespace nlg
