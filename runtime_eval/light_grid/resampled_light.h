// Light resampled into a dense box: what a shader reads from 3-D textures, without the tree, the functions and their weights.
//
// As the talk does it at run time around the camera; here for any box, once. What lies between two texels is the renderer's own
// interpolation, which no function stops at walls: boxes want texels much smaller than the walls are thick, or a field of them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime_eval/light_grid/irradiance.h"

namespace nlg {

// Texels along each axis of a box; their centres lie half a texel inside its faces, as a sampler has them.
struct LightBox {
  PositionM low_m{}, high_m{};            // world, metres; finite
  std::array<uint32_t, 3> texel_count{};  // x, y, z

  size_t texelCount() const { return size_t{texel_count[0]} * texel_count[1] * texel_count[2]; }
  PositionM texelCentre(size_t x, size_t y, size_t z) const;
};

// x is the fastest index, z the slowest.
struct ResampledLight {
  std::vector<float> light;         // kShFloats a texel: radiance as spherical harmonics; 0 where there is none
  std::vector<LightStatus> status;  // by texel: who shows it fills what is faint, unlit or outside as it likes
};

// lookUpLight at the centre of every texel, by vectors. Allocates the result, 109 bytes a texel.
ResampledLight resampleLight(const LightGrid& grid, const LightBox& box, LookUpScratch* scratch);

}  // namespace nlg
