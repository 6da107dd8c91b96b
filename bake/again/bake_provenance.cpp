#include "bake/again/bake_provenance.h"

#include <cmath>
#include <cstdlib>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bake/bake_options.h"
#include "nlg/simd.h"
#include "scene/lights/light_sets.h"
#include "tool/provenance.h"

namespace nlg {
namespace {

constexpr const char* kSpacing = "spacing_m";  // in metadata, where boxes made the lattice finer than it

}  // namespace

nlohmann::ordered_json bakedOptions(const OptionTable& table) {
  nlohmann::ordered_json options = table.toJson();
  // what the grid holds does not depend on the threads, but on the instructions that were chosen; the hashes say which weights
  options.erase("threads");
  options.erase("max_probes");
  options.erase("representation");
  // metres, as grids of before say; the scene's hash tells of another unit that was taken
  if (options.value("unit", 1.0) == 0.0) options["unit"] = 1.0;
  options["simd"] = chosenSimdTarget();
  return options;
}

std::set<std::string> lightSettings(const OptionTable& table) {
  std::set<std::string> names(std::begin(kOfFunctions), std::end(kOfFunctions));
  names.insert({"light_error", "max_bytes", "light_set"});
  LightOptions of_scene;
  OptionTable scene_table("bake");
  describe(of_scene, scene_table);
  const nlohmann::ordered_json of_scene_all = scene_table.describeAsJson(), all = table.describeAsJson();
  for (const auto& option : of_scene_all) names.insert(option.at("name").get<std::string>());
  for (const auto& option : all) {
    if (option.at("group") == kLightGroup) names.insert(option.at("name").get<std::string>());
  }
  return names;
}

GridMetadata bakeMetadata(const PreparedScene& scene, const nlohmann::ordered_json& options,
                          const std::map<std::string, std::string>& weights) {
  std::map<std::string, std::string> inputs = weights;
  if (!scene.source.sha256.empty()) inputs["scene"] = scene.source.sha256;
  inputs[kLightRole] = lightSha256(scene.source);
  if (!lightGroupNames(scene.source).empty()) inputs[kUngroupedRole] = ungroupedLightSha256(scene.source);
  inputs[kSearchedRole] = scene.searched_sha256;
  GridMetadata metadata = {{"scene", scene.source.id}, {"provenance", provenance("nlg-bake", options, inputs).dump()}};
  if (scene.spacing_m != scene.full_tree.frame().spacing_m) metadata[kSpacing] = fmt::format("{}", scene.spacing_m);
  return metadata;
}

double bakedSpacing(const LightGrid& grid, const GridMetadata& metadata) {
  const auto found = metadata.find(kSpacing);
  const double spacing_m = found == metadata.end() ? 0.0 : std::strtod(found->second.c_str(), nullptr);
  return spacing_m > 0.0 && std::isfinite(spacing_m) ? spacing_m : grid.tree.frame().spacing_m;
}

}  // namespace nlg
