// Hostile entities of Quake III levels: whatever the text, it is refused in one line, or what it says of places and light is
// finite.
#include <cmath>

#include "scene/quake/bsp_entities.h"
#include "scene/quake/bsp_light.h"
#include "tests/fuzz/fuzz.h"

namespace nlg::fuzz {
namespace {

constexpr size_t kModelCount = 3;

template <class Vector>
void checkFinite(const Vector& v) {
  for (int axis = 0; axis < 3; ++axis) FUZZ_CHECK(std::isfinite(v[axis]), std::to_string(v[axis]));
}

template <class Vector>
void checkUnit(const Vector& v) {
  checkFinite(v);
  FUZZ_CHECK(std::abs(glm::length(v) - 1.0f) < 1e-3f, std::to_string(glm::length(v)));
}

template <class Vector>
void checkLight(const Vector& rgb) {
  checkFinite(rgb);
  for (int channel = 0; channel < 3; ++channel) FUZZ_CHECK(rgb[channel] >= 0.0f, std::to_string(rgb[channel]));
}

void readAll(std::string_view text) {
  const std::vector<BspEntity> entities = readEntities("level.bsp", text);
  for (const BspStart& start : playerStarts(entities)) checkFinite(start.origin_units);
  const EntityLights lights = entityLights(entities);
  FUZZ_CHECK(lights.lamps.size() == lights.lamp_units.size(), std::to_string(lights.lamps.size()));
  for (const glm::dvec3& place : lights.lamp_units) checkFinite(place);
  for (const Lamp& lamp : lights.lamps) {
    checkLight(lamp.intensity);
    checkUnit(lamp.direction);
    FUZZ_CHECK(lamp.cos_outer <= lamp.cos_inner, std::to_string(lamp.cos_outer));
  }
  for (const Sun& sun : lights.suns) {
    checkLight(sun.irradiance);
    checkUnit(sun.to_sun);
  }
  checkLight(lights.ambient);
  // last: it refuses what the others have no opinion of
  for (const BspPlacement& placement : readPlacements("level.bsp", entities, kModelCount)) checkFinite(placement.origin_units);
}

}  // namespace

void readOne(std::string_view bytes) {
  isTaken([&] { readAll(bytes); });
}

Seeds seeds() {
  return {{"level", R"({ "classname" "worldspawn" "_ambient" "12" "_color" "1 .5 .25" "_noshadersun" "1" }
{ "classname" "info_player_deathmatch" "origin" "16 -32 24" "angle" "90" }
{ "classname" "team_CTF_redspawn" "origin" "0 0 0" }
{ "classname" "func_door" "model" "*1" "origin" "8 8 8" })"},
          {"lamps", R"({ "classname" "light" "origin" "1 2 3" "light" "300" "_color" "1 1 0" "target" "t" "radius" "32" }
{ "classname" "light" "origin" "1 2 3" "_light" "-5" "scale" "-2" "spawnflags" "1" }
{ "classname" "light_sun" "origin" "0 0 9" "_sun" "1" "target" "t" "_deviance" "2" }
{ "classname" "target_position" "targetname" "t" "origin" "1 2 0" }
{ "classname" "lightJunior" "origin" "0 0 0" })"}};
}

std::string mutated(std::string bytes, size_t max_size, Random& random) {
  return mutatedTextOrBlindly(std::move(bytes), max_size, random);
}

}  // namespace nlg::fuzz
