// Chooses the functions that are measured, and the population of each.
#pragma once

#include "datagen/dataset/function_set.h"
#include "validate/generators/populations.h"

namespace nlg {

// The functions that every point of the plot runs on, and the blocks in which they run.
//
// One block: as many functions as a bake gives a generator at once, or a few less. The set must outlive it.
struct FunctionBlock {
  std::vector<uint64_t> functions;     // of the set
  std::vector<StoredFunction> stored;  // the same
  std::vector<uint8_t> phi;            // count x P, one after another: what a generator reads

  int count() const { return static_cast<int>(functions.size()); }
};

// Cuts the list into blocks of at most kBatchCount functions, as equal as they can be.
std::vector<FunctionBlock> makeBlocks(const FunctionSet& set, const std::vector<uint64_t>& functions);

inline constexpr Population kPopulations[] = {Population::all, Population::theta, Population::hard};

const char* populationWords(Population population);  // "functions that take a θ"

struct ChosenFunctions {
  std::vector<uint64_t> with_theta;  // what points run on, as many of every scene
  std::vector<bool> hard;            // of these
  std::vector<uint64_t> bare_tents;  // that take none: in every scene as many beside the others as the scene has in proportion

  uint64_t count(Population population) const;
};

// wanted   functions that take a theta; with fewer all are taken
// throws   InputError when no function takes a theta
ChosenFunctions chooseFunctions(const FunctionSet& set, uint64_t wanted, const PolicyOptions& policy, double hard_tent_rmse);

}  // namespace nlg
