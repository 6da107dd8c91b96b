// The hierarchy of truths in one small scene: how much error every step from solved functions to a generator's adds.
#pragma once

#include <nlohmann/json.hpp>

#include "runtime_eval/evaluator/generator.h"
#include "runtime_eval/fit/direct.h"
#include "validate/solved/comparison.h"

namespace nlg {

// throws   InputError naming the file and what the reader says of it; UsageError when two are of one representation
std::vector<Generator> loadGenerators(const std::vector<std::string>& paths);

// The lists "hierarchy" and "walks" of SCENE.hierarchy.json; keys: docs/reference/formats.md.
nlohmann::ordered_json hierarchyJson(const SolvedScene& scene, const std::vector<Generator>& generators,
                                     const DirectOptions& direct);

}  // namespace nlg
