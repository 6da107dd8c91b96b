// nlg-datagen info FOLDER: what a folder of shards holds, scene by scene, and how hard its functions are.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace nlg {

// Reads every shard (.h5) below a folder, in bounded memory.
// returns   `scenes`, a row for each scene of each split, and `all`: probes, functions, what was left out by reason, and of the functions:
//           those that the bare tent is enough for, hard ones, those of probes in solid, the share of dark points; `tent_blend_rmse`, how
//           many functions lie in each bin of the bare tent's blend RMSE
// throws    InputError where there is no shard, or one of them cannot be read
nlohmann::ordered_json dataCard(const std::string& folder);

// The same as tables for people.
std::string dataCardText(const nlohmann::ordered_json& card);

}  // namespace nlg
