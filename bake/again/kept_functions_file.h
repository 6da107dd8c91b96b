// Reads and writes the file of the incremental bake (layout: docs/reference/formats.md, "Kept functions").
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "bake/again/kept_functions.h"

namespace nlg {

// origin   what functions depend on beside the level: functionOrigin
std::string keptBytes(const KeptThetas& thetas, const nlohmann::ordered_json& origin);

// What an earlier bake kept. Nothing where there is no file yet, or where its origin is another.
// representations   of the bake's generators, in their order
// told              one line for the user, where nothing is known
// throws   InputError when the file is something else; DamageError when it is damaged
KeptThetas readKept(const std::string& path, const nlohmann::ordered_json& origin,
                    const std::vector<Representation>& representations, std::string* told);

// What such a file is, for `info`; nothing where it is something else.
// throws   DamageError when it is damaged
std::optional<nlohmann::ordered_json> describeKept(const std::string& path);

}  // namespace nlg
