// How the bake's choice between representations agrees with the one that direct optimisation would make (the talk: "the
// resolution found this way sometimes doesn't really match the resolution from Adam").
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime_eval/fit/representation_choice.h"
#include "validate/errors/method.h"

namespace nlg {

// One representation on the functions that direct optimisation ran on, in the same order for all representations.
struct ChoiceColumn {
  std::string name;
  int theta_count = 0;
  std::vector<FunctionError> generated, direct;
};

// columns   by rising theta_count; at least two
// returns   "functions"; "agree", "generator_smaller", "generator_larger": shares; "counts": for each pair "generator → direct" of
//           names how many functions; "floats": mean number of parameters by either choice; "rmse_direct": mean error of direct
//           optimisation in the representation that either chose; keys: docs/reference/formats.md
nlohmann::ordered_json choiceJson(const std::vector<ChoiceColumn>& columns, const CheckOptions& check,
                                  const ChoiceOptions& options);

}  // namespace nlg
