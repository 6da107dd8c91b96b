#include "scene/lights/light_sets.h"

#include <algorithm>
#include <functional>
#include <regex>
#include <set>

#include <nlohmann/json.hpp>

#include "nlg/light_grid.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

// One line of UTF-8, as grids hold it.
std::string oneLine(const std::string& text) {
  using Json = nlohmann::json;
  auto name = Json::parse(Json(text).dump(-1, ' ', false, Json::error_handler_t::replace)).get<std::string>();
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return c < ' '; }, ' ');
  return name;
}

// Without the number by which Blender tells copies apart.
std::string groupName(const std::string& text) {
  const size_t dot = text.find_last_of('.');
  const bool is_numbered = dot != std::string::npos && dot > 0 && dot + 1 < text.size() &&
                           text.find_first_not_of("0123456789", dot + 1) == std::string::npos;
  return oneLine(text.substr(0, is_numbered ? dot : std::string::npos));
}

class Grouping {
 public:
  Grouping(bool by_name, Scene* scene) : by_name_(by_name), scene_(*scene) {}

  void run() {
    SceneLight& light = scene_.light;
    light.groups = {};
    const Sky& sky = light.sky;
    if (!sky.image.empty() || shines(sky.zenith) || shines(sky.horizon) || shines(sky.ground))
      light.groups.of_sky = indexOf("sky");
    for (size_t s = 0; s < light.suns.size(); ++s) light.groups.of_sun.push_back(groupOf(labelOf(light.sun_labels, s), "sun"));
    for (size_t l = 0; l < light.lamps.size(); ++l)
      light.groups.of_lamp.push_back(groupOf(labelOf(light.lamp_labels, l), "lamps"));
    std::vector<uint8_t> is_used(scene_.materials.size(), 0);
    for (const uint32_t material : scene_.triangle_material) is_used[material] = 1;
    for (size_t m = 0; m < scene_.materials.size(); ++m) {
      const Material& material = scene_.materials[m];
      const bool counts = is_used[m] != 0 && shines(material.emissive);
      light.groups.of_material.push_back(counts ? groupOf(material.label, "emission") : uint8_t{0});
    }
    if (!light.sky_faces.shine.empty()) light.groups.of_shine = indexOf("emission");
    if (!light.baked.empty()) light.groups.of_baked = indexOf("level");
  }

 private:
  static bool shines(const glm::vec3& light) { return light != glm::vec3(0.0f); }

  static LightLabel labelOf(const std::vector<LightLabel>& labels, size_t index) {
    return index < labels.size() ? labels[index] : LightLabel{};
  }

  uint8_t groupOf(const LightLabel& label, const char* kind) {
    if (!label.group.empty()) return indexOf(oneLine(label.group));
    return indexOf(by_name_ && !label.name.empty() ? groupName(label.name) : kind);
  }

  uint8_t indexOf(const std::string& name) {
    std::vector<std::string>& names = scene_.light.groups.names;
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) return static_cast<uint8_t>(found - names.begin());
    if (names.size() == kMaxLightGroups) {
      throw InputError(scene_.id, "light_groups", "at most " + std::to_string(kMaxLightGroups) + " groups of light",
                       "more, the first too many '" + name + "': --light-groups kind, or lamps put together by light_group");
    }
    names.push_back(name);
    return static_cast<uint8_t>(names.size() - 1);
  }

  const bool by_name_;
  Scene& scene_;
};

constexpr const char* kForm =
    "NAME, NAME=SCENE, or either with OPTION=VALUE behind blanks, each option once: 'night=level_night.glb sky=0 sun=0'; a name "
    "without blanks, ',' and '/'";

LightSet setFrom(const std::string& text, const LightOptions& of_all) {
  const std::string place = "--light-set";
  LightSet set{{}, {}, of_all};
  // sets may differ in options of light alone
  OptionTable table("bake");
  describe(set.options, table);
  std::string names;
  for (const auto& option : table.describeAsJson()) names += (names.empty() ? "" : "|") + option.at("name").get<std::string>();
  // a scene's path may hold blanks and '=': a setting begins with a blank and an option's name
  const std::regex setting(" +(" + names + ")="), form(R"(([^\x01- ,/=\x7f]+)(=(.+?))?(( +()" + names + R"()=.*)?))");
  std::smatch found;
  if (!std::regex_match(text, found, form)) throw UsageError(place, kForm, "'" + text + "'");
  set.name = found[1];
  set.scene = found[3];
  std::set<std::string> given;
  const std::string settings = found[4];
  for (std::sregex_iterator at(settings.begin(), settings.end(), setting), end; at != end;) {
    const std::string option = (*at)[1];
    const auto begin = (*at)[0].second;
    const std::string value(begin, ++at == end ? settings.end() : (*at)[0].first);
    if (!given.insert(option).second) throw UsageError(place, kForm, option + " twice in '" + text + "'");
    if (value.empty()) throw UsageError(place, kForm, "nothing behind " + option + "= in '" + text + "'");
    table.set(option, value, place + " " + set.name + ": " + option);
  }
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

void groupLights(const std::string& how, Scene* scene) {
  scene->light.groups = {};
  if (how == "one") return;
  if (how != "kind" && how != "name") throw UsageError("light_groups", "one, kind or name", "'" + how + "'");
  Grouping(how == "name", scene).run();
}

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
