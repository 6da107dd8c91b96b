// The light grid of Quake III-family engines: where it stands, what it holds, how engines read it (ioquake3, tr_light.c, tr_bsp.c).
//
// A point holds ambient light, directed light and the direction that this comes from. A model is lit by ambient + directed *
// max(0, normal · direction), all three blended trilinearly; points that hold no light are left out, and the rest is scaled up.
// Engines take .6 of the ambient light, add 32 codes to it, and show 255 codes as full brightness: radiance 1.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "export/engine/engine_format.h"
#include "export/engine/texel_light.h"

namespace nlg {

inline constexpr const char* kQuakeFormat = "quake3-lightgrid";

// A level as its file has it.
struct QuakeLevel {
  std::string name;   // maps/NAME.bsp
  std::string bytes;  // of the .bsp
  LightBox box;       // a texel a point of its grid: world, metres, as the scene has it
};

// request   a .bsp file, or PATH:MAP in archives, as for loadScene
// throws    InputError when it cannot be read, or has no light grid of the size that its bounds and gridsize ask for
QuakeLevel readQuakeLevel(const std::string& request);

// A vector of length 1; the other one where it has none.
glm::vec3 unitOr(const glm::vec3& vector, const glm::vec3& other);
// Where most light comes from; up where it comes from everywhere.
glm::vec3 mainDirection(const LightSh& light);

// What a point can show of light with this direction, by least squares over all normals, in two coefficients that a look-up blends
// linearly: the mean, which is that of harmonics, and how much is directed. irradianceSquares measures both as it does harmonics.
LightSh meanAndDirected(const LightSh& light, const glm::vec3& direction);

// lightgrid.raw, of engines that read it beside the lump's directions: 6 float32 a point, in codes. Lump 15, of all: 8 bytes a point.
struct QuakeGridBytes {
  std::string raw, lump;
};
// By texel of the level's box. Where one is not valid all numbers are 0.
QuakeGridBytes quakeGridBytes(const QuakeLevel& level, const std::vector<LightSh>& mean_and_directed,
                              const std::vector<glm::vec3>& directions, const std::vector<uint8_t>& is_valid);

// The level with another lump 15 of the same size.
std::string withLightGrid(const QuakeLevel& level, const std::string& lump);
std::string lightGridOf(const QuakeLevel& level);

// What engines show of a model at a position.
// raw   empty: of an engine that reads the lump alone
EngineIrradiance quakeIrradiance(const QuakeLevel& level, const QuakeGridBytes& bytes);

}  // namespace nlg
