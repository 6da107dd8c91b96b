// The light grid of Quake III-family engines: where it stands, what it holds, how engines read it (ioquake3, tr_light.c, tr_bsp.c).
//
// A point holds ambient light, directed light and the direction that this comes from. A model is lit by ambient + directed *
// max(0, normal · direction), all three blended trilinearly; points that hold no light are left out, and the rest is scaled up.
// Engines take .6 of the ambient light, add 32 codes to it, and show 255 codes as full brightness: radiance 1.
//
// Nearly all levels come without their lamps: compilers take these out of the file. What arrives in air stands in the level's own grid
// alone, whose points the compiler lit one by one. What is wrong there is the blend, through walls.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "datagen/visibility/ray_scene.h"
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
// By texel of the level's box. Where one is not made, numbers are the level's own.
QuakeGridBytes quakeGridBytes(const QuakeLevel& level, const std::vector<LightSh>& mean_and_directed,
                              const std::vector<glm::vec3>& directions, const std::vector<uint8_t>& is_made);

// The level with another lump 15 of the same size.
std::string withLightGrid(const QuakeLevel& level, const std::string& lump);
std::string lightGridOf(const QuakeLevel& level);

// A grid as engines read it: codes that they show.
class QuakeGrid {
 public:
  // raw   empty: of an engine that reads the lump alone
  QuakeGrid(const QuakeLevel& level, const QuakeGridBytes& bytes);

  const TexelLookUp& lookUp() const { return look_up_; }  // points that hold light are valid
  // What engines show of a model, by what points weigh there.
  std::array<float, kShChannels> shown(const ProbeWeights& weights, const float* normal_3) const;
  // Light that would show so, of any normal.
  LightSh light(const ProbeWeights& weights) const;

 private:
  struct Point {
    glm::vec3 ambient{0.0f}, directed{0.0f}, direction{0.0f};
  };
  Point blended(const ProbeWeights& weights) const;

  TexelLookUp look_up_;
  std::vector<Point> points_;  // by texel
};

EngineIrradiance quakeIrradiance(const QuakeLevel& level, const QuakeGridBytes& bytes);

// Light in air of the level's own grid: the engine's blend, of those points alone that a position sees.
class CompiledLight {
 public:
  // rays   of the level's scene, relative to origin_m; must outlive this object
  CompiledLight(const QuakeLevel& level, const RayScene& rays, const glm::dvec3& origin_m);

  // position_m   relative to the scene's origin
  // weights      of points that it sees, but for the last .15 m: compilers light a point in solid beside it. A count of 0 where it sees
  //              none that weighs enough
  void weightsAt(const glm::dvec3& position_m, ProbeWeights* weights) const;
  const QuakeGrid& grid() const { return grid_; }

 private:
  QuakeGrid grid_;
  const RayScene& rays_;
  glm::dvec3 origin_m_;
};

}  // namespace nlg
