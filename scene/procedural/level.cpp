#include "scene/procedural/level.h"

#include <cmath>
#include <numbers>

namespace nlg {
namespace {

// A surface's colour: the given one, made lighter or darker and a little tinted.
uint32_t addVaried(MeshBuilder& mesh, Random& random, const glm::dvec3& colour) {
  const double shade = random.uniform(0.75, 1.25);
  Material material;
  for (int channel = 0; channel < 3; ++channel) {
    const double value = colour[channel] * shade * random.uniform(0.9, 1.1);
    material.base_color[channel] = static_cast<float>(std::clamp(value, 0.02, 0.9));
  }
  return mesh.addMaterial(material);
}

uint32_t addLampMaterial(MeshBuilder& mesh, Random& random) {
  const double warmth = random.uniform();
  Material material;
  material.base_color = glm::vec3(0.8f);
  material.emissive = glm::vec3(glm::dvec3(1.0, 0.95 - 0.2 * warmth, 0.9 - 0.5 * warmth) * random.uniform(6.0, 14.0));
  return mesh.addMaterial(material);
}

Palette makePalette(MeshBuilder& mesh, Random& random) {
  Palette palette{};
  palette.wall = addVaried(mesh, random, {0.62, 0.58, 0.52});
  palette.inner_wall = addVaried(mesh, random, {0.70, 0.69, 0.64});
  palette.floor = addVaried(mesh, random, {0.36, 0.27, 0.19});
  palette.ceiling = addVaried(mesh, random, {0.75, 0.74, 0.72});
  palette.roof = addVaried(mesh, random, {0.42, 0.19, 0.13});
  palette.stone = addVaried(mesh, random, {0.50, 0.47, 0.42});
  palette.wood = addVaried(mesh, random, {0.45, 0.29, 0.15});
  palette.dark_wood = addVaried(mesh, random, {0.20, 0.12, 0.07});
  palette.metal = addVaried(mesh, random, {0.35, 0.36, 0.38});
  palette.cloth = addVaried(mesh, random, {0.35, 0.15, 0.20});
  palette.ground = addVaried(mesh, random, {0.22, 0.28, 0.12});
  palette.rock = addVaried(mesh, random, {0.33, 0.31, 0.28});
  palette.leaf = addVaried(mesh, random, {0.10, 0.25, 0.07});
  palette.lamp = addLampMaterial(mesh, random);
  return palette;
}

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;
constexpr double kNightChance = 1.0 / 3.0;
const glm::dvec3 kBlue(0.45, 0.65, 1.0), kHaze(0.85, 0.92, 1.0), kEarth(0.30, 0.27, 0.22), kSunlight(1.0, 0.93, 0.80);

Sun drawSun(Random& random) {
  const double turn = 360.0 * random.uniform() * kRadiansPerDegree;
  const double rise = random.uniform(15.0, 65.0) * kRadiansPerDegree;
  Sun sun;
  sun.to_sun = glm::normalize(glm::vec3(std::cos(turn) * std::cos(rise), std::sin(rise), std::sin(turn) * std::cos(rise)));
  sun.irradiance = glm::vec3(kSunlight * random.uniform(6.0, 14.0));
  return sun;
}

}  // namespace

Level::Level(uint64_t seed) : random(seed), palette(makePalette(mesh, random)) {}

double Level::pick(double low, double high) {
  const int steps = static_cast<int>((high - low) * 20.0 + 0.5);
  return low + 0.05 * random.below(static_cast<uint32_t>(steps + 1));
}

Daylight drawDaylight(uint64_t seed) {
  Random random(seed);
  const bool is_night = random.chance(kNightChance);
  const double brightness = is_night ? random.uniform(0.005, 0.02) : random.uniform(0.8, 2.0);
  Daylight daylight;
  daylight.sky.zenith = glm::vec3(kBlue * (0.7 * brightness));
  daylight.sky.horizon = glm::vec3(kHaze * brightness);
  daylight.sky.ground = glm::vec3(kEarth * brightness);
  if (!is_night) daylight.suns.push_back(drawSun(random));
  return daylight;
}

}  // namespace nlg
