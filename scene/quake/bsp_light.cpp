#include "scene/quake/bsp_light.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

namespace nlg {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRadiansPerDegree = kPi / 180.0;

// The engine shifts light by two bits (r_mapOverBrightBits), whether on loading or by the display's gamma.
constexpr double kLightPerCode = 4.0 / 255.0;

// The compilers' own constants (q3map and q3map2: pointScale, areaScale, formFactorValueScale, linearScale): a light's number
// becomes codes of the lightmap.
constexpr double kPointScale = 7500.0;
constexpr double kAreaScale = 0.25 * 3.0;
constexpr double kLinearScale = 1.0 / 8000.0;
constexpr double kDefaultLight = 300.0;
constexpr double kDefaultSpotRadius = 64.0;
constexpr double kSpotSlack = 16.0, kSpotFade = 32.0;  // units: a spot's rim
constexpr double kLampRadiusUnits = 8.0;
constexpr uint32_t kLinearFlag = 1;

double numberOf(const BspEntity& entity, std::string_view key, double otherwise) {
  return leadingNumber(textOf(entity, key)).value_or(otherwise);
}

// Irradiance of what adds this to the codes of a lightmap that faces it.
double irradianceOf(double codes) { return kPi * kLightPerCode * codes; }

// Where lights aim at: the origins of all entities that have a name, by it. Of a name that comes twice the first one counts. Found
// once for all lights: tens of thousands of each would take minutes otherwise.
using Targets = std::map<std::string_view, std::optional<glm::dvec3>>;
Targets targetsOf(const std::vector<BspEntity>& entities) {
  Targets targets;
  for (const BspEntity& entity : entities) {
    const std::string_view name = textOf(entity, "targetname");
    if (!name.empty()) targets.try_emplace(name, threeNumbers(textOf(entity, "origin")));
  }
  return targets;
}

// A spot's cone reaches radius + 16 units around its target, and fades over the last 32 of them.
void aimLamp(const BspEntity& entity, const glm::dvec3& way, Lamp* lamp) {
  const double distance = glm::length(way);
  if (!(distance > 0.0)) return;
  const double radius = std::max(0.0, numberOf(entity, "radius", kDefaultSpotRadius));
  lamp->direction = glm::vec3(sceneAxes(way / distance));
  lamp->cos_outer = static_cast<float>(std::cos(std::atan2(radius + kSpotSlack, distance)));
  lamp->cos_inner = static_cast<float>(std::cos(std::atan2(std::max(0.0, radius + kSpotSlack - kSpotFade), distance)));
}

class EntityLightReader {
 public:
  explicit EntityLightReader(const std::vector<BspEntity>& entities) : entities_(entities), targets_(targetsOf(entities)) {}

  EntityLights read() {
    for (const BspEntity& entity : entities_) {
      const std::string_view classname = textOf(entity, "classname");
      if (classname == "worldspawn") readWorld(entity);
      // a lightJunior lights the grid alone
      if (classname.starts_with("light") && classname != "lightJunior") readLight(entity);
    }
    return std::move(lights_);
  }

 private:
  static glm::vec3 colourOf(const BspEntity& entity) {
    return hueOf(threeNumbers(textOf(entity, "_color")).value_or(glm::dvec3(1.0)));
  }

  void readWorld(const BspEntity& world) {
    const double ambient = numberOf(world, "_ambient", numberOf(world, "ambient", 0.0));
    lights_.ambient = colourOf(world) * static_cast<float>(std::clamp(ambient, 0.0, 255.0) * kLightPerCode);
    lights_.has_shader_suns = numberOf(world, "_noshadersun", 0.0) != 1.0;
  }

  void readLight(const BspEntity& entity) {
    const std::optional<glm::dvec3> origin = threeNumbers(textOf(entity, "origin"));
    if (!origin) {
      ++lights_.lamps_without_origin;
      return;
    }
    double strength = numberOf(entity, "_light", numberOf(entity, "light", kDefaultLight));
    if (strength == 0.0) strength = kDefaultLight;
    strength *= numberOf(entity, "scale", 1.0);
    // a negative light takes light away: no lamp does
    if (!(strength > 0.0)) return;
    const auto target = targets_.find(textOf(entity, "target"));
    const glm::dvec3* const aim = target != targets_.end() && target->second ? &*target->second : nullptr;
    if (numberOf(entity, "_sun", 0.0) == 1.0) {
      addSun(entity, strength, aim != nullptr ? *origin - *aim : glm::dvec3(0.0, 0.0, 1.0));
      return;
    }
    Lamp lamp;
    lamp.radius_m = static_cast<float>(kLampRadiusUnits * kBspMetresPerUnit);
    const bool is_linear =
        (static_cast<uint32_t>(std::clamp(numberOf(entity, "spawnflags", 0.0), 0.0, 65535.0)) & kLinearFlag) != 0;
    const double codes_at_a_unit = is_linear ? linearStrength(strength) : strength * kPointScale;
    lights_.linear_lamps += is_linear;
    lamp.intensity = colourOf(entity) * static_cast<float>(irradianceOf(codes_at_a_unit) * kBspMetresPerUnit * kBspMetresPerUnit);
    if (aim != nullptr) aimLamp(entity, *aim - *origin, &lamp);
    lights_.lamps.push_back(lamp);
    lights_.lamp_units.push_back(*origin);
  }

  // A linear light gives reach - distance: at half its reach as much as reach³ / 8 over the square of the distance does.
  static double linearStrength(double strength) {
    const double reach = strength * kPointScale * kLinearScale;
    return reach * reach * reach / 8.0;
  }

  void addSun(const BspEntity& entity, double strength, const glm::dvec3& to_sun) {
    if (!(glm::length(to_sun) > 0.0)) return;
    Sun sun;
    sun.to_sun = glm::vec3(glm::normalize(sceneAxes(to_sun)));
    sun.irradiance = colourOf(entity) * static_cast<float>(irradianceOf(strength));
    const double deviance = std::clamp(numberOf(entity, "_deviance", 0.0), 0.0, 90.0) * kRadiansPerDegree;
    sun.angular_radius = std::max(sun.angular_radius, static_cast<float>(deviance));
    lights_.suns.push_back(sun);
  }

  const std::vector<BspEntity>& entities_;
  const Targets targets_;
  EntityLights lights_;
};

}  // namespace

glm::vec3 lightOf(const BspColour& colour) {
  return glm::vec3(colour[0], colour[1], colour[2]) * static_cast<float>(kLightPerCode);
}

double surfaceRadiance(double surface_light) { return kLightPerCode * kAreaScale * surface_light; }

// the compiler spreads it evenly over azimuth and elevation: level ground gets 2 / pi of it
double skyRadiance(double sky_light) { return kLightPerCode * (2.0 / kPi) * sky_light; }

glm::vec3 hueOf(const glm::dvec3& colour) {
  const double most = std::max({colour.x, colour.y, colour.z});
  if (!(most > 0.0)) return glm::vec3(1.0f);
  return glm::max(glm::vec3(colour / most), glm::vec3(0.0f));
}

Sun sunOf(const ScriptSun& script) {
  const double turn = script.degrees * kRadiansPerDegree, rise = script.elevation * kRadiansPerDegree;
  Sun sun;
  sun.to_sun = glm::vec3(sceneAxes({std::cos(turn) * std::cos(rise), std::sin(turn) * std::cos(rise), std::sin(rise)}));
  sun.irradiance = hueOf(script.colour) * static_cast<float>(irradianceOf(script.intensity));
  sun.angular_radius = std::max(sun.angular_radius, static_cast<float>(script.deviance * kRadiansPerDegree));
  return sun;
}

EntityLights entityLights(const std::vector<BspEntity>& entities) { return EntityLightReader(entities).read(); }

}  // namespace nlg
