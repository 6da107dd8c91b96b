#include "scene/gltf_light.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <tiny_gltf.h>

#include "tool/error.h"

namespace nlg {
namespace {

constexpr const char* kExtension = "KHR_lights_punctual";
constexpr double kBrightest = 1e12;
constexpr double kRightAngle = 1.5707963267948966;
constexpr double kHair = 1e-3;  // of the outer cone: by how much the inner one stays inside

// How lights are odd, and which ones.
class Oddities {
 public:
  void add(const std::string& how, const std::string& light) { lights_[how].push_back(light); }
  std::vector<std::string> notes() const {
    std::vector<std::string> notes;
    for (const auto& [how, lights] : lights_) {
      const size_t others = lights.size() - 1;
      const std::string more = others == 0 ? "" : others == 1 ? " and another one" : fmt::format(" and {} others", others);
      notes.push_back(fmt::format("{}{}: {}", lights[0], more, how));
    }
    return notes;
  }

 private:
  std::map<std::string, std::vector<std::string>> lights_;  // by what is said of them
};

class LightParser {
 public:
  LightParser(const std::string& path, const std::string& place, const tinygltf::Value& value, Oddities* oddities)
      : path_(path), place_(place), value_(value), oddities_(oddities) {}

  GltfLight parse() const {
    if (!value_.IsObject()) fail("", "an object", "another value");
    GltfLight light;
    if (value_.Has("name") && value_.Get("name").IsString()) light.label.name = value_.Get("name").Get<std::string>();
    if (value_.Has("extras")) light.label.group = lightGroupOf(value_.Get("extras"));
    const std::string type = value_.Has("type") && value_.Get("type").IsString() ? value_.Get("type").Get<std::string>() : "";
    light.is_sun = type == "directional";
    light.is_spot = type == "spot";
    if (!light.is_sun && !light.is_spot && type != "point")
      leaveOut("a type that is none of directional, point and spot; left out", &light);
    const glm::vec3 strength = colour() * static_cast<float>(number(value_, "intensity", 1.0));
    for (int channel = 0; channel < 3; ++channel) {
      if (!(strength[channel] <= kBrightest)) fail(": intensity times color", "1e12 at most", std::to_string(strength[channel]));
      if (strength[channel] < 0.0f) leaveOut("light below 0; left out", &light);
    }
    light.strength = strength;
    if (light.is_spot) readCone(&light);
    return light;
  }

 private:
  [[noreturn]] void fail(const std::string& what, const std::string& expected, const std::string& got) const {
    throw InputError(path_, place_ + what, expected, got);
  }

  void note(const std::string& how) const { oddities_->add(how, place_); }
  void leaveOut(const std::string& how, GltfLight* light) const {
    if (!light->is_left_out) note(how);
    light->is_left_out = true;
  }

  double number(const tinygltf::Value& from, const char* key, double otherwise) const {
    if (!from.Has(key)) return otherwise;
    const tinygltf::Value& value = from.Get(key);
    if (!value.IsNumber()) fail(std::string(": ") + key, "a number", "another value");
    return value.GetNumberAsDouble();
  }

  glm::vec3 colour() const {
    if (!value_.Has("color")) return glm::vec3(1.0f);
    const tinygltf::Value& value = value_.Get("color");
    glm::vec3 colour(0.0f);
    for (int channel = 0; channel < 3; ++channel) {
      if (!value.IsArray() || value.ArrayLen() != 3 || !value.Get(channel).IsNumber())
        fail(": color", "three numbers", "another value");
      colour[channel] = static_cast<float>(value.Get(channel).GetNumberAsDouble());
    }
    // intensity times colour says what is meant all the same; a little above 1 is an exporter's rounding
    const bool is_positive = std::min({colour.r, colour.g, colour.b}) >= 0.0f;
    if (is_positive && std::max({colour.r, colour.g, colour.b}) > 1.001f) note("a colour above 1; taken as it is");
    return colour;
  }

  void readCone(GltfLight* light) const {
    // both angles have defaults, and an empty object is none to tinygltf
    const tinygltf::Value spot = value_.Has("spot") ? value_.Get("spot") : tinygltf::Value();
    double inner = number(spot, "innerConeAngle", 0.0), outer = number(spot, "outerConeAngle", 0.5 * kRightAngle);
    if (outer > kRightAngle * 1.001) note("a spot's outer cone beyond a right angle; taken as one");
    outer = std::min(outer, kRightAngle);
    if (!(outer > 0.0)) return leaveOut("a spot's outer cone that is empty; left out", light);
    if (inner >= outer || inner < 0.0) {
      note("a spot's inner cone that is not inside its outer one; brought inside");
      inner = inner < 0.0 ? 0.0 : (1.0 - kHair) * outer;
    }
    light->cos_inner = static_cast<float>(std::cos(inner));
    light->cos_outer = static_cast<float>(std::cos(outer));
  }

  const std::string& path_;
  const std::string place_;
  const tinygltf::Value& value_;
  Oddities* oddities_;
};

// "light 3", with its name where it has one.
std::string lightPlace(size_t idx, const tinygltf::Value& light) {
  std::string place = "light " + std::to_string(idx);
  if (!light.IsObject() || !light.Has("name") || !light.Get("name").IsString()) return place;
  return place + " (" + light.Get("name").Get<std::string>().substr(0, 60) + ")";
}

}  // namespace

std::vector<GltfLight> readGltfLights(const std::string& path, const tinygltf::Model& model, std::vector<std::string>* notes) {
  std::vector<GltfLight> lights;
  const auto extension = model.extensions.find(kExtension);
  if (extension == model.extensions.end() || !extension->second.Has("lights")) return lights;
  const tinygltf::Value& list = extension->second.Get("lights");
  if (!list.IsArray()) throw InputError(path, std::string(kExtension) + ": lights", "an array", "another value");
  Oddities oddities;
  for (size_t i = 0; i < list.ArrayLen(); ++i) {
    const tinygltf::Value& light = list.Get(static_cast<int>(i));
    lights.push_back(LightParser(path, lightPlace(i, light), light, &oddities).parse());
  }
  for (std::string& note : oddities.notes()) notes->push_back(std::move(note));
  return lights;
}

std::string lightGroupOf(const tinygltf::Value& extras) {
  const bool says = extras.IsObject() && extras.Has(kLightGroupKey) && extras.Get(kLightGroupKey).IsString();
  return says ? extras.Get(kLightGroupKey).Get<std::string>() : std::string();
}

bool isOfBlender(const tinygltf::Model& model) {
  return model.asset.generator.find("Khronos glTF Blender I/O") != std::string::npos;
}

int lightOfNode(const std::string& path, const std::string& place, const tinygltf::Node& node, size_t light_count) {
  const auto extension = node.extensions.find(kExtension);
  if (extension == node.extensions.end() || !extension->second.Has("light")) return -1;
  const tinygltf::Value& value = extension->second.Get("light");
  const double idx = value.IsNumber() ? value.GetNumberAsDouble() : -1.0;
  if (!(idx >= 0.0 && idx < static_cast<double>(light_count) && idx == std::floor(idx)))
    throw InputError(path, place + ": light", "a light below " + std::to_string(light_count),
                     value.IsNumber() ? std::to_string(idx) : "another value");
  return static_cast<int>(idx);
}

Lamp lampOf(const GltfLight& light, const glm::dvec3& direction) {
  Lamp lamp;
  lamp.intensity = light.strength;
  lamp.radius_m = kGltfLampRadius_m;
  lamp.direction = glm::vec3(direction);
  lamp.cos_inner = light.cos_inner;
  lamp.cos_outer = light.cos_outer;
  return lamp;
}

Sun sunOf(const GltfLight& light, const glm::dvec3& direction) {
  Sun sun;
  sun.to_sun = glm::vec3(-direction);
  sun.irradiance = light.strength;
  return sun;
}

}  // namespace nlg
