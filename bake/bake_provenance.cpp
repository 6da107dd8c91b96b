#include "bake/bake_provenance.h"

#include <nlohmann/json.hpp>

#include "runtime_eval/simd/simd_target.h"
#include "tool/provenance.h"

namespace nlg {

nlohmann::ordered_json bakedOptions(const OptionTable& table) {
  nlohmann::ordered_json options = table.toJson();
  // what the grid holds does not depend on the threads, but on the instructions that were chosen; the hashes say which weights
  options.erase("threads");
  options.erase("max_probes");
  options.erase("representation");
  options["simd"] = chosenSimdTarget();
  return options;
}

GridMetadata bakeMetadata(const SceneSource& source, const nlohmann::ordered_json& options,
                          const std::map<std::string, std::string>& weights) {
  std::map<std::string, std::string> inputs = weights;
  if (!source.sha256.empty()) inputs["scene"] = source.sha256;
  inputs[kLightRole] = sceneLightSha256(source.scene);
  return {{"scene", source.id}, {"provenance", provenance("nlg-bake", options, inputs).dump()}};
}

}  // namespace nlg
