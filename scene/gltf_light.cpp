#include "scene/gltf_light.h"

#include <cmath>

#include <tiny_gltf.h>

#include "tool/error.h"

namespace nlg {
namespace {

constexpr const char* kExtension = "KHR_lights_punctual";
constexpr double kBrightest = 1e12;
constexpr double kRightAngle = 1.5707963267948966;

class LightParser {
 public:
  LightParser(const std::string& path, const std::string& place, const tinygltf::Value& value)
      : path_(path), place_(place), value_(value) {}

  GltfLight parse() const {
    if (!value_.IsObject()) fail("", "an object", "another value");
    GltfLight light;
    const std::string type = value_.Has("type") && value_.Get("type").IsString() ? value_.Get("type").Get<std::string>() : "";
    light.is_sun = type == "directional";
    light.is_spot = type == "spot";
    if (!light.is_sun && !light.is_spot && type != "point")
      fail(": type", "directional, point or spot", type.empty() ? "none" : type.substr(0, 40));
    light.strength = colour() * static_cast<float>(number(value_, "intensity", 1.0, kBrightest));
    if (light.is_spot) readCone(&light);
    return light;
  }

 private:
  [[noreturn]] void fail(const std::string& what, const std::string& expected, const std::string& got) const {
    throw InputError(path_, place_ + what, expected, got);
  }

  // A number from 0 to this much.
  double number(const tinygltf::Value& from, const char* key, double otherwise, double most) const {
    if (!from.Has(key)) return otherwise;
    const tinygltf::Value& value = from.Get(key);
    const double number = value.IsNumber() ? value.GetNumberAsDouble() : -1.0;
    if (!(number >= 0.0 && number <= most))
      fail(std::string(": ") + key, "a number from 0 to " + std::to_string(most),
           value.IsNumber() ? std::to_string(number) : "none");
    return number;
  }

  glm::vec3 colour() const {
    if (!value_.Has("color")) return glm::vec3(1.0f);
    const tinygltf::Value& value = value_.Get("color");
    glm::vec3 colour(-1.0f);
    if (value.IsArray() && value.ArrayLen() == 3) {
      for (int channel = 0; channel < 3; ++channel) {
        const tinygltf::Value& one = value.Get(channel);
        if (one.IsNumber()) colour[channel] = static_cast<float>(one.GetNumberAsDouble());
      }
    }
    for (int channel = 0; channel < 3; ++channel) {
      if (!(colour[channel] >= 0.0f && colour[channel] <= 1.001f)) fail(": color", "three numbers from 0 to 1", "another value");
    }
    return colour;
  }

  void readCone(GltfLight* light) const {
    if (!value_.Has("spot") || !value_.Get("spot").IsObject()) fail(": spot", "an object", "none");
    const tinygltf::Value& spot = value_.Get("spot");
    const double inner = number(spot, "innerConeAngle", 0.0, kRightAngle);
    const double outer = number(spot, "outerConeAngle", 0.5 * kRightAngle, kRightAngle * 1.001);
    if (!(inner < outer)) fail(": spot", "an inner angle below the outer one", std::to_string(inner));
    light->cos_inner = static_cast<float>(std::cos(inner));
    light->cos_outer = static_cast<float>(std::cos(outer));
  }

  const std::string& path_;
  const std::string place_;
  const tinygltf::Value& value_;
};

}  // namespace

std::vector<GltfLight> readGltfLights(const std::string& path, const tinygltf::Model& model) {
  std::vector<GltfLight> lights;
  const auto extension = model.extensions.find(kExtension);
  if (extension == model.extensions.end() || !extension->second.Has("lights")) return lights;
  const tinygltf::Value& list = extension->second.Get("lights");
  if (!list.IsArray()) throw InputError(path, std::string(kExtension) + ": lights", "an array", "another value");
  for (size_t i = 0; i < list.ArrayLen(); ++i)
    lights.push_back(LightParser(path, "light " + std::to_string(i), list.Get(static_cast<int>(i))).parse());
  return lights;
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
