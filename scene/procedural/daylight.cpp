#include "scene/procedural/daylight.h"

#include <cmath>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

constexpr double kRadiansPerDegree = 0.017453292519943295;
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
