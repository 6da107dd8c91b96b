// Which functions are measured, and which population each belongs to.
#pragma once

#include "datagen/dataset/function_set.h"
#include "runtime_eval/fit/theta_policy.h"
#include "validate/errors/populations.h"

namespace nlg {

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
