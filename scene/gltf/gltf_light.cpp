#include "scene/gltf/gltf_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

#include <fmt/format.h>
#include <tiny_gltf.h>

#include "scene/gltf/gltf_nodes.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr const char* kExtension = "KHR_lights_punctual";
constexpr double kRightAngle = std::numbers::pi / 2.0;
constexpr double kHair = 1e-3;  // of the outer cone: by how much the inner one stays inside

// Blender's exporter: its versions (major, minor, patch: 3 04 040), and below what no light is in its standard unit.
// Of 3.4.40 on lights are in units: https://github.com/KhronosGroup/glTF-Blender-IO, pull request 1760. Lost suns: issues 2675 and 2709.
constexpr std::string_view kBlender = "Khronos glTF Blender I/O";
constexpr int kFirstInUnits = 304040, kFirstLosingSuns = 500020, kLastLosingSuns = 501018;
constexpr double kLumensPerWatt = 683.0, kFourPi = 12.566370614359172;
constexpr double kLeastSun = 50.0, kLeastLamp = 150.0;  // lux, .07 W/m²; cd, 2.8 W, which would be 1,900 W without the 683
constexpr int kManyDigits = 5;

class LightParser {
 public:
  LightParser(const std::string& path, const std::string& place, const tinygltf::Value& value, Oddities* odd)
      : path_(path), place_(place), value_(value), odd_(odd) {}

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
    light.intensity = number(value_, "intensity", 1.0);
    const glm::vec3 strength = colour() * static_cast<float>(light.intensity);
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

  void note(const std::string& how) const { odd_->add(how, place_); }
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
  Oddities* odd_;
};

// Of asset.generator, "Khronos glTF Blender I/O v4.3.47": 40347; 0: it says none.
int versionOfBlender(const tinygltf::Model& model) {
  const size_t at = model.asset.generator.find(kBlender);
  int major = 0, minor = 0, patch = 0;
  if (at == std::string::npos ||
      std::sscanf(model.asset.generator.c_str() + at + kBlender.size(), " v%3d.%2d.%3d", &major, &minor, &patch) != 3)
    return 0;
  return major * 100000 + minor * 1000 + patch;
}

// Digits that a number has, if a float holds it: 1 of 40, 2 of .25; kManyDigits, where they are as many or more.
int digitsOf(double number) {
  const double scale = std::pow(10.0, std::floor(std::log10(number)));
  for (int digits = 1; digits < kManyDigits; ++digits) {
    const double shifted = number / scale * std::pow(10.0, digits - 1);
    if (std::abs(shifted - std::round(shifted)) < 2e-7 * shifted) return digits;
  }
  return kManyDigits;
}

LightUnit unitOfBlender(const tinygltf::Model& model, const std::vector<GltfLight>& lights) {
  using Kind = LightUnit::Kind;
  // the version decides, else the numbers, else what would be too faint (docs/theory/light.md, Units)
  const int version = versionOfBlender(model);
  if (version > 0 && version < kFirstInUnits) return {Kind::raw, "exporters before 3.4.40 know no other"};
  // by unit: standard, unitless, raw
  std::array<int, 3> votes{};
  double most_sun = 0.0, most_lamp = 0.0, watts = 0.0;
  for (const GltfLight& light : lights) {
    if (light.is_left_out || !(light.intensity > 0.0)) continue;
    double& most = light.is_sun ? most_sun : most_lamp;
    most = std::max(most, light.intensity);
    // power in watts as an artist would have typed it, under each unit; numbers with many digits do not vote
    const double power = light.is_sun ? light.intensity : light.intensity * kFourPi;
    const std::array<int, 3> digits = {digitsOf(power / kLumensPerWatt), digitsOf(power), digitsOf(light.intensity)};
    const int least = *std::min_element(digits.begin(), digits.end());
    for (size_t unit = 0; unit < 3 && least < kManyDigits; ++unit) votes[unit] += digits[unit] == least ? 1 : 0;
    watts = std::max(watts, power);
  }
  if (watts == 0.0) return {};
  const auto sign = [&](double shown) { return fmt::format("its powers are round numbers then, such as {:.4g} W", shown); };
  // a unit ahead of the others decides; the text says what power it gives
  if (votes[0] > std::max(votes[1], votes[2])) return {Kind::standard, sign(watts / kLumensPerWatt)};
  if (votes[1] > votes[0] && votes[1] >= votes[2]) return {Kind::same, sign(watts)};
  if (votes[2] > votes[0]) return {Kind::raw, sign(std::max(most_sun, most_lamp))};
  // no unit is in front: the default, unless lights would be too faint in it
  const bool is_bright = most_sun > 0.0 ? most_sun >= kLeastSun : most_lamp >= kLeastLamp;
  return is_bright ? LightUnit{Kind::standard, "the exporter's default"}
                   : LightUnit{Kind::same, "in the exporter's default they would be too faint"};
}

// Of other programs, by a part of their generator's name (docs/theory/light.md, Units).
LightUnit unitOfOther(const std::string& generator) {
  using Kind = LightUnit::Kind;
  constexpr const char* kTooDark = " they would be pi too dark, which --light-unit pi mends";
  const auto isOf = [&](const char* name) { return generator.find(name) != std::string::npos; };
  // energies as the editor shows them; its renderer multiplies them by pi, unless the project has physical light units
  if (isOf("Godot Engine")) return {Kind::over_pi, "Godot multiplies the energies that it writes by pi"};
  if (isOf("glTFast"))
    return {Kind::unsure, std::string("glTFast does not say of which of Unity's render pipelines they are; of URP") + kTooDark};
  constexpr std::string_view kThree = "THREE.GLTFExporter";
  constexpr int kFirstPhysical = 155;
  int revision = 0;
  if (const size_t at = generator.find(kThree); at != std::string::npos) {
    std::sscanf(generator.c_str() + at + kThree.size(), " r%4d", &revision);
    if (revision >= kFirstPhysical) return {};
    return {Kind::unsure,
            std::string("three.js before r155 multiplies by pi unless physicallyCorrectLights was set; without it") + kTooDark};
  }
  if (generator.empty() || isOf("UnityGLTF") || isOf("Babylon.js")) return {};
  return {Kind::unsure, "\"" + generator.substr(0, 60) + "\" may write others, for which there is --light-unit"};
}

// "light 3", with its name where it has one.
std::string lightPlace(size_t idx, const tinygltf::Value& light) {
  std::string place = "light " + std::to_string(idx);
  if (!light.IsObject() || !light.Has("name") || !light.Get("name").IsString()) return place;
  return place + " (" + light.Get("name").Get<std::string>().substr(0, 60) + ")";
}

}  // namespace

std::vector<GltfLight> readGltfLights(const std::string& path, const tinygltf::Model& model, Oddities* odd) {
  std::vector<GltfLight> lights;
  const tinygltf::Value* list = memberOf(model.extensions, kExtension, "lights");
  for (size_t i = 0; list != nullptr && i < list->ArrayLen(); ++i) {
    const tinygltf::Value& light = list->Get(static_cast<int>(i));
    lights.emplace_back();
    lights.back().is_left_out =
        !odd->attempt("left out", [&] { lights.back() = LightParser(path, lightPlace(i, light), light, odd).parse(); }) ||
        lights.back().is_left_out;
  }
  return lights;
}

std::string lightGroupOf(const tinygltf::Value& extras) {
  const bool says = extras.IsObject() && extras.Has(kLightGroupKey) && extras.Get(kLightGroupKey).IsString();
  return says ? extras.Get(kLightGroupKey).Get<std::string>() : std::string();
}

bool isOfBlender(const tinygltf::Model& model) { return model.asset.generator.find(kBlender) != std::string::npos; }

LightUnit unitOfLights(const tinygltf::Model& model, const std::vector<GltfLight>& lights) {
  return isOfBlender(model) ? unitOfBlender(model, lights) : unitOfOther(model.asset.generator);
}

std::string noteOfLostSuns(const tinygltf::Model& model, const std::vector<GltfLight>& lights) {
  const int version = isOfBlender(model) ? versionOfBlender(model) : 0;
  size_t lost = 0, suns = 0;
  for (const GltfLight& light : lights) {
    suns += light.is_sun ? 1 : 0;
    lost += light.is_sun && (std::abs(light.intensity - kLumensPerWatt) < 1e-3 || light.intensity == 1.0) ? 1 : 0;
  }
  if (version < kFirstLosingSuns || version > kLastLosingSuns || lost == 0 || lost < suns) return "";
  return counted(lost, "sun is", "suns are") +
         " of 1 W/m²: so Blender 5.0 to 5.1.0 wrote every sun, whatever its strength, and left out the colours of all lights; "
         "export "
         "from a later one, or give the sun by --sun";
}

int lightOfNode(const std::string& path, const std::string& place, const tinygltf::Node& node, size_t light_count) {
  const tinygltf::Value* value = memberOf(node.extensions, kExtension, "light");
  if (value == nullptr) return -1;
  const double idx = value->IsNumber() ? value->GetNumberAsDouble() : -1.0;
  if (!(idx >= 0.0 && idx < static_cast<double>(light_count) && idx == std::floor(idx)))
    throw InputError(path, place + ": light", "a light below " + std::to_string(light_count),
                     value->IsNumber() ? std::to_string(idx) : "another value");
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
