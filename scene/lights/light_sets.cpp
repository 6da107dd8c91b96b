#include "scene/lights/light_sets.h"

#include <algorithm>
#include <functional>

#include <nlohmann/json.hpp>

#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr const char* kForm =
    "NAME, NAME=SCENE, or either with OPTION=VALUE behind blanks, each option once: 'night=level_night.glb sky=0 sun=0'; a name "
    "without blanks, ',' and '/'";

// The last " OPTION=" that begins a setting, since paths may hold blanks.
size_t lastSetting(const std::string& text, const std::vector<std::string>& names) {
  for (size_t blank = text.rfind(' '); blank != std::string::npos && blank > 0; blank = text.rfind(' ', blank - 1)) {
    const size_t equals = text.find('=', blank);
    if (equals == std::string::npos) continue;
    if (std::find(names.begin(), names.end(), text.substr(blank + 1, equals - blank - 1)) != names.end()) return blank;
  }
  return std::string::npos;
}

LightSet setFrom(const std::string& text, const LightOptions& of_all) {
  const std::string place = "--light-set";
  LightSet set{{}, {}, of_all};
  OptionTable table("bake");
  describe(set.options, table);
  std::vector<std::string> names;
  for (const auto& option : table.describeAsJson()) names.push_back(option.at("name").get<std::string>());
  std::string rest = text;
  std::vector<std::pair<std::string, std::string>> settings;  // from the last to the first
  for (size_t blank = lastSetting(rest, names); blank != std::string::npos; blank = lastSetting(rest, names)) {
    const size_t equals = rest.find('=', blank);
    std::string option = rest.substr(blank + 1, equals - blank - 1);
    if (std::any_of(settings.begin(), settings.end(), [&](const auto& other) { return other.first == option; }))
      throw UsageError(place, kForm, option + " twice in '" + text + "'");
    if (equals + 1 == rest.size()) throw UsageError(place, kForm, "nothing behind " + option + "= in '" + text + "'");
    settings.emplace_back(std::move(option), rest.substr(equals + 1));
    rest.erase(rest.find_last_not_of(' ', blank) + 1);
  }
  const size_t equals = rest.find('=');
  set.name = rest.substr(0, equals);
  if (equals != std::string::npos) set.scene = rest.substr(equals + 1);
  const bool is_named = !set.name.empty() && std::none_of(set.name.begin(), set.name.end(), [](unsigned char c) {
    return c <= ' ' || c == ',' || c == '/' || c == 0x7f;
  });
  if (!is_named || (equals != std::string::npos && set.scene.empty())) throw UsageError(place, kForm, "'" + text + "'");
  std::for_each(settings.rbegin(), settings.rend(), [&](const auto& setting) {
    table.set(setting.first, setting.second, place + " " + set.name + ": " + setting.first);
  });
  return set;
}

std::string sha256OfAll(const SceneSource& source, const std::function<std::string(const Scene&)>& sha256Of) {
  if (source.light_sets.empty()) return sha256Of(source.scene);
  std::string text;
  const std::vector<const Scene*> scenes = litScenes(source);
  for (size_t s = 0; s < scenes.size(); ++s) text += source.light_sets[s] + '\n' + sha256Of(*scenes[s]) + '\n';
  return sha256(text);
}

}  // namespace

std::vector<LightSet> lightSetsFrom(const std::vector<std::string>& texts, const LightOptions& of_all) {
  std::vector<LightSet> sets;
  for (const std::string& text : texts) {
    LightSet set = setFrom(text, of_all);
    if (std::any_of(sets.begin(), sets.end(), [&](const LightSet& other) { return other.name == set.name; }))
      throw UsageError("--light-set", "names that differ", "'" + set.name + "' twice");
    sets.push_back(std::move(set));
  }
  return sets;
}

std::vector<std::string> filesOfLight(const std::vector<std::string>& texts, const LightOptions& of_all) {
  std::vector<std::string> files;
  const auto addSky = [&](const LightOptions& options) {
    if (!options.sky.empty()) files.push_back(options.sky.front());
  };
  addSky(of_all);
  for (const LightSet& set : lightSetsFrom(texts, of_all)) {
    addSky(set.options);
    if (!set.scene.empty()) files.push_back(set.scene);
  }
  return files;
}

std::vector<const Scene*> litScenes(const SceneSource& source) {
  std::vector<const Scene*> scenes = {&source.scene};
  for (const Scene& other : source.lit_otherwise) scenes.push_back(&other);
  return scenes;
}

std::vector<std::string> lightGroupNames(const SceneSource& source) {
  if (source.light_sets.empty()) return source.scene.light.groups.names;
  std::vector<std::string> names;
  const std::vector<const Scene*> scenes = litScenes(source);
  for (size_t s = 0; s < scenes.size(); ++s) {
    const LightGroups& groups = scenes[s]->light.groups;
    if (groups.names.empty()) names.push_back(source.light_sets[s]);
    for (const std::string& group : groups.names) names.push_back(source.light_sets[s] + "/" + group);
  }
  return names;
}

size_t firstGroupCount(const SceneSource& source) {
  return source.light_sets.empty() ? source.scene.light.groups.names.size() : source.scene.light.groups.count();
}

std::string lightSha256(const SceneSource& source) {
  return sha256OfAll(source, [](const Scene& scene) { return sceneLightSha256(scene); });
}

std::string ungroupedLightSha256(const SceneSource& source) {
  return sha256OfAll(source, [](const Scene& scene) { return sceneLightSha256(scene, {}); });
}

}  // namespace nlg
