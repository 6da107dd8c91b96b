// Reads the light of a Quake III level, in the unit and axes of a Scene (docs/reference/quake3_light.md).
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "scene/model/scene_light.h"
#include "scene/quake/bsp_entities.h"
#include "scene/quake/bsp_file.h"
#include "scene/quake/bsp_shader.h"

namespace nlg {

inline constexpr double kBspMetresPerUnit = 0.0254;

// (x, y, z), z up, becomes (x, z, -y).
inline glm::dvec3 sceneAxes(const glm::dvec3& quake) { return {quake.x, quake.z, -quake.y}; }

// Light of a lightmap's texel, a vertex's colour or a cell of the grid: 4 for 255, what the engine makes of it.
glm::vec3 lightOf(const BspColour& colour);

// Radiance of a face of this q3map_surfacelight; of a sky of this q3map_skylight.
double surfaceRadiance(double surface_light);
double skyRadiance(double sky_light);

// A light's colour as the compiler takes it: the largest channel is 1; white where there is none.
glm::vec3 hueOf(const glm::dvec3& colour);

Sun sunOf(const ScriptSun& sun);

// What the entities say. The compilers strip most lights from what they write.
struct EntityLights {
  std::vector<glm::dvec3> lamp_units;  // where each lamp stands, in the file's axes and units
  std::vector<Lamp> lamps;             // but for their position
  std::vector<Sun> suns;
  glm::vec3 ambient{0.0f};  // light that the compiler added to every texel and vertex
  bool has_shader_suns = true;
  uint32_t lamps_without_origin = 0;  // left out
  uint32_t linear_lamps = 0;          // fade out at a distance; here by its square: the same irradiance half way there
};
EntityLights entityLights(const std::vector<BspEntity>& entities);

}  // namespace nlg
