#include "bake/again/bake_provenance.h"

#include <cmath>
#include <cstdlib>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "nlg/simd.h"
#include "runtime_eval/probe_tree/probe_tree_data.h"
#include "tool/error.h"
#include "tool/input_file.h"
#include "tool/provenance.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSpacing = "spacing_m";  // in metadata, where boxes made the lattice finer than it

bool areGrids(std::string_view bytes) {
  return bytes.size() > 8 && bytes.substr(8).starts_with(R"({"__metadata__":{)") && hold(bytes, R"("kind":"nlg-light-grid")");
}

bool areReports(std::string_view bytes) { return bytes.starts_with("{\"scene\":") && hold(bytes, "\"peak_memory_bytes\":"); }

}  // namespace

const OwnFiles kGridFiles = {"a light grid", areGrids}, kReportFiles = {"what a bake said of itself", areReports};

Json bakedOptions(const OptionTable& table) {
  Json options = table.toJson();
  // what the grid holds does not depend on the threads, but on the instructions that were chosen; the hashes say which weights
  options.erase("threads");
  options.erase("max_probes");
  options.erase("representation");
  // metres, as grids of before say; the scene's hash tells of another unit that was taken
  if (options.value("unit", 1.0) == 0.0) options["unit"] = 1.0;
  options["simd"] = chosenSimdTarget();
  return options;
}

GridMetadata bakeMetadata(const PreparedScene& scene, const Json& options, const std::map<std::string, std::string>& weights) {
  std::map<std::string, std::string> inputs = weights;
  if (!scene.source.sha256.empty()) inputs["scene"] = scene.source.sha256;
  inputs[kLightRole] = sceneLightSha256(scene.source.scene);
  if (!scene.source.scene.light.groups.names.empty()) inputs[kUngroupedRole] = sceneLightSha256(scene.source.scene, {});
  inputs[kSearchedRole] = scene.searched_sha256;
  GridMetadata metadata = {{"scene", scene.source.id}, {"provenance", provenance("nlg-bake", options, inputs).dump()}};
  if (scene.spacing_m != scene.full_tree.frame().spacing_m) metadata[kSpacing] = fmt::format("{}", scene.spacing_m);
  return metadata;
}

BakedGrid readBakedGrid(const std::string& path) {
  BakedGrid baked;
  requireRead(path, readLightGridFile(path, &baked.grid, &baked.metadata), "a light grid");
  return baked;
}

BakedGrid readLitGrid(const std::string& path) {
  BakedGrid baked = readBakedGrid(path);
  if (baked.grid.light.empty()) throw InputError(path, "light", "a grid that was baked with light", "a grid without light");
  return baked;
}

double bakedSpacing(const LightGrid& grid, const GridMetadata& metadata) {
  const auto found = metadata.find(kSpacing);
  const double spacing_m = found == metadata.end() ? 0.0 : std::strtod(found->second.c_str(), nullptr);
  return spacing_m > 0.0 && std::isfinite(spacing_m) ? spacing_m : grid.tree.frame().spacing_m;
}

Json provenanceAt(const GridMetadata& metadata, const std::string& place) {
  const auto found = metadata.find("provenance");
  const Json all = found == metadata.end() ? Json() : Json::parse(found->second, nullptr, false);
  const Json::json_pointer pointer(place);
  return all.contains(pointer) ? all[pointer] : Json();
}

Json originOf(const std::string& path, const BakedGrid& baked) {
  const auto found = baked.metadata.find("provenance");
  Json origin = found == baked.metadata.end() ? Json() : Json::parse(found->second, nullptr, false);
  if (!origin.is_object() || !origin["options"].is_object() || !origin["inputs"].is_object())
    throw InputError(path, "has no provenance; bake the grid again");
  if (!origin["inputs"].contains(kLightRole))
    throw InputError(path, "was baked by another version of nlg-bake; bake the grid again");
  return origin;
}

std::map<std::string, std::string> weightsOf(const Json& origin) {
  std::map<std::string, std::string> weights;
  for (const auto& [role, sha256] : origin.at("inputs").items()) {
    if (role.starts_with(kWeightsRole)) weights[role] = sha256.get<std::string>();
  }
  return weights;
}

std::vector<ChangedSetting> changedSettings(const OptionTable& table, const Json& origin) {
  std::vector<ChangedSetting> changed;
  const Json options = bakedOptions(table);
  for (const auto& [name, now] : options.items()) {
    const Json before = origin["options"].value(name, Json());
    if (before != now) changed.push_back({name, before.dump(), now.dump()});
  }
  return changed;
}

bool sameGeometry(const SceneSource& source, const BakedGrid& baked, const Json& origin) {
  const std::string sha256 = origin["inputs"].value("scene", std::string());
  if (!sha256.empty() || !source.sha256.empty()) return sha256 == source.sha256;
  // procedural scenes are their names
  const auto id = baked.metadata.find("scene");
  return id != baked.metadata.end() && id->second == source.id;
}

std::string textAt(const GridMetadata& metadata, const std::string& place) {
  const Json value = provenanceAt(metadata, place);
  return value.is_string() ? value.get<std::string>() : std::string();
}

std::string otherSceneOrLight(const GridMetadata& metadata, const SceneSource& source) {
  const auto scene = metadata.find("scene");
  if (scene != metadata.end() && scene->second != source.id) return "baked from " + scene->second + ", and this is " + source.id;
  const std::string light = textAt(metadata, "/inputs/" + std::string(kLightRole));
  const std::string ungrouped = textAt(metadata, "/inputs/" + std::string(kUngroupedRole));
  const std::string& baked_light = ungrouped.empty() ? light : ungrouped;
  if (baked_light.empty() || baked_light == sceneLightSha256(source.scene, {})) return "";
  return "baked with other light than the scene has here; give the same --sky, --sun and --intensity";
}

KnownAir knownAir(const std::string& path, const BakedGrid& baked) {
  return {originOf(path, baked)["inputs"].value(kSearchedRole, std::string()), &baked.grid.tree};
}

bool standsWhere(const PreparedScene& scene, const BakedGrid& baked) {
  const ProbeTreeData here = probeTreeData(scene.treeInWorld()), there = probeTreeData(baked.grid.tree);
  return here.frame.first_m == there.frame.first_m && here.frame.spacing_m == there.frame.spacing_m &&
         here.frame.root_count == there.frame.root_count && here.child_mask == there.child_mask &&
         here.used_mask == there.used_mask && here.cell_count == there.cell_count;
}

}  // namespace nlg
