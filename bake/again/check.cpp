#include "bake/again/check.h"

#include <iostream>
#include <utility>

#include <nlohmann/json.hpp>

#include "bake/load_generators.h"
#include "tool/error.h"

namespace nlg {

std::vector<std::string> changesSince(const std::string& path, const BakedGrid& baked, const SceneSource& source,
                                      const OptionTable& table, const std::map<std::string, std::string>& weights) {
  const nlohmann::ordered_json origin = originOf(path, baked), &inputs = origin["inputs"];
  std::vector<std::string> changes;
  const bool is_same = sameGeometry(source, baked, origin);
  if (!is_same) changes.push_back("geometry changed");
  // the hash of light holds geometry, too
  const std::string light = inputs.value(kLightRole, std::string());
  if (is_same && light != sceneLightSha256(source.scene)) {
    const std::string ungrouped = inputs.value(kUngroupedRole, light);
    changes.push_back(ungrouped == sceneLightSha256(source.scene, {}) ? kGroupsChanged : kLightChanged);
  }
  // the grid holds its name
  if (const auto id = baked.metadata.find("scene"); is_same && (id == baked.metadata.end() || id->second != source.id))
    changes.push_back("the scene's name changed to " + source.id);
  for (const auto& [name, before, now] : changedSettings(table, origin)) {
    // the instructions of another machine are no change of mind
    if (name != "simd") changes.push_back("setting changed: " + name + " from " + before + " to " + now);
  }
  if (weightsOf(origin) != weights) changes.push_back("weights changed");
  return changes;
}

void runCheck(BakeRequest request, const BakeOptions& options, const OptionTable& table) {
  for (const auto& [is_given, what] :
       {std::pair(!request.relit.empty(), "--relight"), std::pair(request.out_is_given, "--out")}) {
    if (is_given) throw UsageError(std::string("--check cannot be combined with ") + what + ": nothing is baked");
  }
  checkOutputs(request, {request.scene, request.config, request.checked});
  const BakedGrid baked = readBakedGrid(request.checked);
  if (request.weights.empty()) request.weights = shippedWeights(options.representation, weightsFolders());
  const NamedGenerators named = loadGeneratorsOf(request);
  SceneSource source = loadLitScene(request.scene, options);
  std::vector<std::string> changes = changesSince(request.checked, baked, source, table, named.sha256);
  // other lamps may move probes: the scene is set up to see where they would stand
  if (changes == std::vector<std::string>{kLightChanged} &&
      !standsWhere({std::move(source), options, knownAir(request.checked, baked)}, baked))
    changes.push_back("probes would stand elsewhere");
  writeJson(request, {{"schema_version", 1}, {"grid", request.checked}, {"changes", changes}});
  if (request.json != "-") {
    if (changes.empty()) std::cout << request.checked << ": fresh\n";
    for (const std::string& change : changes) std::cout << request.checked << ": " << change << '\n';
  }
  if (!changes.empty()) throw ToolError(ExitCode::check_failed, request.checked + ": out of date");
}

}  // namespace nlg
