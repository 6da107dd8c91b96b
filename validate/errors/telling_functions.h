// Which functions to look at, and what a picture of them shows.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "validate/errors/policy_words.h"

namespace nlg {

struct TellingFunction {
  std::string which;  // "best", "median", "p95", "worst"
  uint64_t function = 0;
};

// By the error of what is stored, among the hard functions; among those that take a theta when none is hard, among all when none does.
std::vector<TellingFunction> tellingFunctions(const MeasuredWord& stored, const Populations& populations);

// Slices through them, for slices.json: docs/reference/formats.md.
void appendSlices(const Representation& representation, const PolicyWords& words, const FunctionSet& set,
                  const Populations& populations, nlohmann::ordered_json* slices);

}  // namespace nlg
