#include "export/used_by/baked_weights.h"

#include <nlohmann/json.hpp>

#include "runtime_eval/light_grid/light_grid_file.h"
#include "tool/atomic_file.h"
#include "tool/error.h"
#include "tool/require_read.h"

namespace nlg {
namespace {

constexpr std::string_view kInput = "weights of ";  // of the provenance of a light grid: role → SHA-256

BakedWeights ofLightGrid(const std::string& path) {
  LightGrid grid;
  GridMetadata metadata;
  requireRead(path, readLightGridFile(path, &grid, &metadata), "the light grid of nlg-bake");
  BakedWeights baked;
  baked.scene = metadata["scene"];
  try {
    const nlohmann::json provenance = nlohmann::json::parse(metadata["provenance"]);
    for (const auto& [role, sha256] : provenance.at("inputs").items()) {
      if (role.starts_with(kInput)) baked.sha256[role.substr(kInput.size())] = sha256.get<std::string>();
    }
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path, "provenance", "the inputs of a bake", error.what());
  }
  for (const Representation& representation : grid.representations) baked.used.emplace_back(representationName(representation));
  return baked;
}

BakedWeights ofReport(const std::string& path) {
  BakedWeights baked;
  try {
    const nlohmann::json report = nlohmann::json::parse(readFile(path));
    baked.scene = report.at("scene").get<std::string>();
    for (const auto& [name, weights] : report.at("weights").items()) {
      baked.sha256[name] = weights.at("sha256").get<std::string>();
    }
    for (const auto& [name, functions] : report.at("representations").items()) {
      if (functions.get<uint64_t>() > 0) baked.used.push_back(name);
    }
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path, "report", "the line of JSON that nlg-bake writes with --json", error.what());
  }
  return baked;
}

}  // namespace

BakedWeights readBakedWeights(const std::string& path) {
  const BakedWeights baked = path.ends_with(".json") ? ofReport(path) : ofLightGrid(path);
  for (const std::string& name : baked.used) {
    if (!baked.sha256.contains(name)) throw InputError(path, "weights of " + name, "their SHA-256", "none");
  }
  return baked;
}

}  // namespace nlg
