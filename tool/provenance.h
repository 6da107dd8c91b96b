// The provenance of an artefact, stored in every file that a stage writes.
#pragma once

#include <map>
#include <string>

#include <nlohmann/json.hpp>

namespace nlg {

// The revision of the sources that this binary was built from: `git describe --always --dirty`, or "unknown" outside git.
const char* sourceRevision();

// {"tool", "revision", "options", "inputs"}: options as OptionTable::toJson gives them, inputs as role → SHA-256.
// Holds no time and no path, so that the same seeds give the same bytes everywhere.
nlohmann::ordered_json provenance(const std::string& tool, const nlohmann::ordered_json& options,
                                  const std::map<std::string, std::string>& input_sha256);

}  // namespace nlg
