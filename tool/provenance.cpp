#include "tool/provenance.h"

#include "nlg_revision.h"

namespace nlg {

const char* sourceRevision() { return NLG_REVISION; }

nlohmann::ordered_json provenance(const std::string& tool, const nlohmann::ordered_json& options,
                                  const std::map<std::string, std::string>& input_sha256) {
  return {{"tool", tool}, {"revision", sourceRevision()}, {"options", options}, {"inputs", input_sha256}};
}

}  // namespace nlg
