// Checks the values of a shard, for writer and reader. Internal to this folder.
#pragma once

#include <string>
#include <vector>

#include "datagen/dataset/shard.h"

namespace nlg {

inline constexpr const char* kShardKind = "nlg-weighting-functions";

// Where and why a shard breaks its contract; an empty place when it does not.
struct Fault {
  std::string place, expected, got;
};

Fault pointCountFault(uint64_t point_count, uint64_t test_point_count);
Fault duplicateRuleFault(const DuplicateRule& rule);

// What must hold of the values once all lengths are known to be right.
// first_function   what the arrays' first row is called in messages
Fault valueFault(const FunctionRows& rows, uint64_t first_function = 0);

// {rows, columns …}
std::vector<uint64_t> withRows(uint64_t rows, std::vector<uint64_t> columns);

}  // namespace nlg
