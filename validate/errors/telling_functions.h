// Which functions to look at, and what a picture of them shows.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "validate/errors/policy_words.h"

namespace nlg {

struct TellingFunction {
  std::string which;  // "p5", "median", "p95", "worst"
  uint64_t function = 0;
};

// By the blend RMSE of what is stored, among the hard functions. Where none is hard, among those that take a theta; where none does, among
// all. At a percentile stands the function with the most valid points among those whose ranks lie within a two-hundredth of all
// around it: a picture of solid says nothing.
std::vector<TellingFunction> tellingFunctions(const MeasuredWord& stored, const FunctionSet& set, const Populations& populations);

// Slices through them, for slices.json: docs/reference/formats.md.
void appendSlices(const Representation& representation, const PolicyWords& words, const FunctionSet& set,
                  const Populations& populations, nlohmann::ordered_json* slices);

}  // namespace nlg
