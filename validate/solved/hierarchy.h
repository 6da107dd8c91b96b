// The hierarchy of truths in one small scene: how much error every step adds, from solved functions over target functions and the
// best that a representation is known to do with them to what a bake makes of them, word by word.
#pragma once

#include <nlohmann/json.hpp>

#include "runtime_eval/evaluator/generator.h"
#include "runtime_eval/fit/direct.h"
#include "runtime_eval/fit/theta_policy.h"
#include "validate/solved/comparison.h"

namespace nlg {

// The lists "hierarchy" and "walks" of SCENE.hierarchy.json; keys: docs/reference/formats.md.
nlohmann::ordered_json hierarchyJson(const SolvedScene& scene, const std::vector<Generator>& generators,
                                     const PolicyOptions& policy, const DirectOptions& direct);

}  // namespace nlg
