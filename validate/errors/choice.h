// How the bake's choice between representations agrees with the one that direct optimisation would make (the talk: "the
// resolution found this way sometimes doesn't really match the resolution from Adam").
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime_eval/evaluator/generator.h"
#include "validate/errors/populations.h"

namespace nlg {

// Direct optimisation in one representation.
struct ChoiceColumn {
  const Generator* generator = nullptr;
  std::vector<FunctionCheck> direct;  // by function of the sample
};

// Runs the policy over all the generators at once, as a bake does, on the sample's functions.
// columns   by rising theta_count; at least two
// returns   "functions"; "agree", "generator_smaller", "generator_larger": shares; "counts": for each pair "generator → direct" of
//           names how many functions; "floats": mean number of parameters by either choice; "rmse_direct": mean error of direct
//           optimisation in the representation that either chose; keys: docs/reference/formats.md
nlohmann::ordered_json choiceJson(const std::vector<ChoiceColumn>& columns, const FunctionSet& set,
                                  const Populations& populations, const ValidateOptions& options);

}  // namespace nlg
