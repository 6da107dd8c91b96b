#include "bake/again/relight.h"

#include <algorithm>
#include <chrono>
#include <iostream>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bake/again/bake_provenance.h"
#include "bake/report/bake_report.h"
#include "scene/lights/light_groups.h"
#include "tool/error.h"
#include "tool/processor_time.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

// Settings that no relight changes and none can ask for: what functions took, on which machine.
constexpr const char* kOfFunctions[] = {"refine_seconds", "simd"};

// In provenance: that of each state of light that was added, by name.
constexpr const char* kStates = "states";

// Settings that functions do not depend on, and those.
std::set<std::string> lightSettings(const OptionTable& table) {
  std::set<std::string> names(std::begin(kOfFunctions), std::end(kOfFunctions));
  names.insert({"light_error", "max_bytes"});
  LightOptions of_scene;
  OptionTable scene_table("bake");
  describe(of_scene, scene_table);
  const Json of_scene_all = scene_table.describeAsJson(), all = table.describeAsJson();
  for (const auto& option : of_scene_all) names.insert(option.at("name").get<std::string>());
  for (const auto& option : all) {
    if (option.at("group") == kLightGroup) names.insert(option.at("name").get<std::string>());
  }
  return names;
}

void requireFunctionsOf(const PreparedScene& scene, const OptionTable& table, const std::vector<std::string>& asked,
                        const std::string& path, const BakedGrid& baked) {
  const Json origin = originOf(path, baked), &settings = origin["options"];
  if (!sameGeometry(scene.source, baked, origin)) {
    throw InputError(path, "scene: the geometry of " + scene.source.id + " is not that of the grid; bake the grid again");
  }
  const std::set<std::string> of_light = lightSettings(table);
  for (const auto& [name, before, now] : changedSettings(table, origin)) {
    if (of_light.count(name) == 0)
      throw InputError(path, name, before + ", as in the bake of the grid (its options are needed again)", now);
  }
  for (const char* name : {"thin_error", "max_bytes"}) {
    if (const Json thinned_by = settings.value(name, Json(0.0)); thinned_by != Json(0.0))
      throw InputError(path,
                       std::string(name) + ": a thinned grid cannot be relit; bake it with 0 instead of " + thinned_by.dump());
  }
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

// The groups of other light states, which stay where one more is asked for.
std::vector<LightGroup> otherStates(const std::string& state, const std::string& path, const BakedGrid& baked) {
  const Json origin = originOf(path, baked);
  const std::vector<LightGroup>& groups = baked.grid.groups;
  if (state.empty() || state == origin["options"].value("light_state", std::string())) {
    // else one of several would be gone without a word
    if (origin.contains(kStates))
      throw InputError(path, "light_state", "a grid to which no other light was added", "one that holds several states of light");
    return {};
  }
  if (groups.empty())
    throw InputError(path, "light_state", "a grid that was baked with a --light-state of its own", "one without");
  if (std::any_of(groups.begin(), groups.end(), [&](const LightGroup& group) { return isOfState(group.name, state); }))
    throw InputError(path, "light_state", "a name that no group of its light has", state);
  return groups;
}

}  // namespace

void runRelight(BakeRequest request, const BakeOptions& options, const OptionTable& table) {
  std::vector<std::string> inputs = options.scene_light.sky;
  inputs.insert(inputs.end(), {request.scene, request.config, request.relit});
  checkOutputs(request, inputs);
  if (!request.weights.empty())
    throw UsageError("--relight cannot be combined with --weights: it reuses the functions of the grid");
  if (options.light == "none") throw UsageError("--relight cannot be combined with --light none: it computes light only");
  if (!request.out_is_given) throw UsageError("--relight needs --out: the grid to write");
  const auto start = std::chrono::steady_clock::now();
  BakedGrid baked = readBakedGrid(request.relit);
  // cells that the bake of the grid found without air are not searched again
  const PreparedScene scene = prepareScene(request, options, {}, knownAir(request.relit, baked));
  requireFunctionsOf(scene, table, options.representation, request.relit, baked);
  const std::string& state = options.scene_light.light_state;
  const std::vector<LightGroup> states = otherStates(state, request.relit, baked);
  if (!states.empty() && (options.thin_error > 0.0 || options.max_bytes > 0.0))
    throw UsageError(
        "--light-state cannot be combined with --thin-error and --max-bytes: other light needs what this one does not");
  const size_t group_count = states.size() + scene.source.scene.light.groups.names.size();
  if (group_count > kMaxLightGroups)
    throw UsageError("--light-state", fmt::format("at most {} groups of light in all", kMaxLightGroups),
                     std::to_string(group_count));
  if (!baked.grid.groups.empty() && scene.source.scene.light.groups.names.empty())
    std::cerr << "light: the grid's " << baked.grid.groups.size()
              << " groups of light become one; to keep them, give --light-groups as in its bake\n";
  // what tells of functions stays
  const Json origin = originOf(request.relit, baked);
  Json settings = bakedOptions(table);
  for (const char* name : kOfFunctions) settings[name] = origin["options"].value(name, settings[name]);
  GridMetadata metadata = bakeMetadata(scene, settings, weightsOf(origin));
  if (!states.empty()) {
    // the grid begins as it was; what was added is noted
    Json kept = origin;
    kept[kStates][state] = Json::parse(metadata.at("provenance"));
    metadata = baked.metadata;
    metadata["provenance"] = kept.dump();
  }
  RelightReport report;
  report.light = bakeLight(scene, options, &baked.grid, metadata, states);
  report.light.groups.clear();
  for (const LightGroup& group : baked.grid.groups) report.light.groups.push_back(group.name);
  report.file_bytes = writeGrid(request, baked.grid, options, metadata);
  warnOfLight(scene, options, report.light);
  report.scene = scene.source.id;
  report.grid = request.relit;
  report.probes = baked.grid.tree.probeCount();
  report.peak_memory_bytes = peakMemoryBytes();
  report.notes = scene.source.notes.size();
  report.wall_s = secondsSince(start);
  std::cerr << toSummary(report, request.out);
  writeJson(request, toJson(report));
}

}  // namespace nlg
