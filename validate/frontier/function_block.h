// The functions that every point of the plot runs on, and the blocks in which they run.
#pragma once

#include "datagen/dataset/function_set.h"
#include "runtime_eval/support/weighting_function.h"

namespace nlg {

// One block: as many functions as a bake gives a generator at once, or a few less. The set must outlive it.
struct FunctionBlock {
  std::vector<uint64_t> functions;     // of the set
  std::vector<StoredFunction> stored;  // the same
  std::vector<uint8_t> phi;            // count x P, one after another: what a generator reads

  int count() const { return static_cast<int>(functions.size()); }
};

// Cuts the list into blocks of at most kBatchCount functions, as equal as they can be.
std::vector<FunctionBlock> makeBlocks(const FunctionSet& set, const std::vector<uint64_t>& functions);

}  // namespace nlg
