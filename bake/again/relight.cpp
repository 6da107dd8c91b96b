#include "bake/again/relight.h"

#include <algorithm>
#include <set>

#include <nlohmann/json.hpp>

#include "bake/again/bake_provenance.h"
#include "runtime_eval/probe_tree/probe_tree_data.h"
#include "scene/lights/light_sets.h"
#include "tool/error.h"
#include "tool/input_file.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

bool sameTree(const ProbeTree& a, const ProbeTree& b) {
  const ProbeTreeData data_a = probeTreeData(a), data_b = probeTreeData(b);
  return data_a.frame.first_m == data_b.frame.first_m && data_a.frame.spacing_m == data_b.frame.spacing_m &&
         data_a.frame.root_count == data_b.frame.root_count && data_a.child_mask == data_b.child_mask &&
         data_a.used_mask == data_b.used_mask && data_a.cell_count == data_b.cell_count;
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

bool sameGeometry(const SceneSource& source, const BakedGrid& baked, const Json& origin) {
  const std::string sha256 = origin["inputs"].value("scene", std::string());
  if (!sha256.empty() || !source.sha256.empty()) return sha256 == source.sha256;
  // procedural scenes are their names
  const auto id = baked.metadata.find("scene");
  return id != baked.metadata.end() && id->second == source.id;
}

// Calls visit(name, before, now) for every setting that has changed.
template <class Visit>
void forEachChange(const OptionTable& table, const Json& origin, const Visit& visit) {
  const Json options = bakedOptions(table);
  for (const auto& [name, now] : options.items()) {
    const Json before = origin["options"].value(name, Json());
    if (before != now) visit(name, before.dump(), now.dump());
  }
}

}  // namespace

BakedGrid readBakedGrid(const std::string& path) {
  BakedGrid baked;
  requireRead(path, readLightGridFile(path, &baked.grid, &baked.metadata), "a light grid");
  return baked;
}

KnownAir knownAir(const std::string& path, const BakedGrid& baked) {
  return {originOf(path, baked)["inputs"].value(kSearchedRole, std::string()), &baked.grid.tree};
}

void requireFunctionsOf(const PreparedScene& scene, const OptionTable& table, const std::vector<std::string>& asked,
                        const std::string& path, const BakedGrid& baked) {
  const Json origin = originOf(path, baked);
  if (!sameGeometry(scene.source, baked, origin)) {
    throw InputError(path, "scene: the geometry of " + scene.source.id + " is not that of the grid; bake the grid again");
  }
  const std::set<std::string> of_light = lightSettings(table);
  forEachChange(table, origin, [&](const std::string& name, const std::string& before, const std::string& now) {
    if (of_light.count(name) == 0) throw InputError(path, name, before + ", as in the bake of the grid", now);
  });
  for (const char* name : {"thin_error", "max_bytes"}) {
    if (const Json thinned_by = origin["options"].value(name, Json(0.0)); thinned_by != Json(0.0))
      throw InputError(path,
                       std::string(name) + ": a thinned grid cannot be relit; bake it with 0 instead of " + thinned_by.dump());
  }
  // else a grid of several would become one of a single light without a word
  if (const Json sets = origin["options"].value("light_set", Json::array()); !sets.empty() && scene.source.light_sets.empty())
    throw InputError(path, "light_set: --relight needs a --light-set for each set to keep of " + sets.dump());
  std::vector<std::string> representations;
  for (const Representation& representation : baked.grid.representations)
    representations.emplace_back(representationName(representation));
  const bool is_default = asked == BakeOptions().representation;
  const auto isAsked = [&](const std::string& name) { return std::find(asked.begin(), asked.end(), name) != asked.end(); };
  if (!is_default && !std::all_of(representations.begin(), representations.end(), isAsked)) {
    throw InputError(path, "representation", Json(representations).dump() + ", as in the bake of the grid", Json(asked).dump());
  }
  if (!standsWhere(scene, baked)) {
    throw InputError(path, "probes: lamps or extent_m would move the probes of the grid; bake the grid again");
  }
}

bool standsWhere(const PreparedScene& scene, const BakedGrid& baked) { return sameTree(scene.treeInWorld(), baked.grid.tree); }

std::vector<std::string> changesSince(const std::string& path, const BakedGrid& baked, const SceneSource& source,
                                      const OptionTable& table, const std::map<std::string, std::string>& weights) {
  const Json origin = originOf(path, baked);
  std::vector<std::string> changes;
  const bool is_same = sameGeometry(source, baked, origin);
  if (!is_same) changes.push_back("geometry changed");
  // the hash of light holds geometry, too
  const std::string light = origin["inputs"].value(kLightRole, std::string());
  if (is_same && light != lightSha256(source)) {
    const std::string ungrouped = origin["inputs"].value(kUngroupedRole, light);
    changes.push_back(ungrouped == ungroupedLightSha256(source) ? kGroupsChanged : kLightChanged);
  }
  // the grid holds its name
  if (const auto id = baked.metadata.find("scene"); is_same && (id == baked.metadata.end() || id->second != source.id))
    changes.push_back("the scene's name changed to " + source.id);
  forEachChange(table, origin, [&](const std::string& name, const std::string& before, const std::string& now) {
    // the instructions of another machine are no change of mind
    if (name != "simd") changes.push_back("setting changed: " + name + " from " + before + " to " + now);
  });
  std::map<std::string, std::string> before;
  for (const auto& [role, sha256] : origin["inputs"].items()) {
    if (role.starts_with(kWeightsRole)) before[role] = sha256.get<std::string>();
  }
  if (before != weights) changes.push_back("weights changed");
  return changes;
}

LightStatistics relight(const PreparedScene& scene, const BakeOptions& options, const OptionTable& table, BakedGrid* baked) {
  std::map<std::string, std::string> weights;
  const Json origin = Json::parse(baked->metadata.at("provenance"));
  for (const auto& [role, sha256] : origin.at("inputs").items()) {
    if (role.starts_with(kWeightsRole)) weights[role] = sha256.get<std::string>();
  }
  Json settings = bakedOptions(table);
  for (const char* name : kOfFunctions) settings[name] = origin.at("options").value(name, settings[name]);
  baked->metadata = bakeMetadata(scene, settings, weights);
  return bakeLight(scene, options, &baked->grid, baked->metadata);
}

}  // namespace nlg
