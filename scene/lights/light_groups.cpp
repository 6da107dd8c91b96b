#include "scene/lights/light_groups.h"

#include <algorithm>

#include "nlg/light_grid.h"
#include "tool/error.h"
#include "tool/printable.h"

namespace nlg {
namespace {

// Without the number by which Blender tells copies apart.
std::string groupName(const std::string& text) {
  const size_t dot = text.find_last_of('.');
  const bool is_numbered = dot != std::string::npos && dot > 0 && dot + 1 < text.size() &&
                           text.find_first_not_of("0123456789", dot + 1) == std::string::npos;
  return printable(text.substr(0, is_numbered ? dot : std::string::npos));
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
    if (!label.group.empty()) return indexOf(printable(label.group));
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

}  // namespace

void groupLights(const std::string& how, const std::string& state, Scene* scene) {
  LightGroups& groups = scene->light.groups;
  groups = {};
  if (how != "one" && how != "kind" && how != "name") throw UsageError("light_groups", "one, kind or name", "'" + how + "'");
  const auto isUnfit = [](unsigned char c) { return c <= ' ' || c == ',' || c == '/' || c == 0x7f; };
  if (std::any_of(state.begin(), state.end(), isUnfit))
    throw UsageError("light_state", "a name without blanks, ',' and '/'", "'" + state + "'");
  if (how != "one") Grouping(how == "name", scene).run();
  if (state.empty()) return;
  for (std::string& name : groups.names) name = state + "/" + name;
  if (groups.names.empty()) groups.names.push_back(state);
}

bool isOfState(const std::string& group, const std::string& state) { return group == state || group.starts_with(state + "/"); }

}  // namespace nlg
