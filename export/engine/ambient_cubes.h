// Ambient cubes in one 3-D texture of RGB9E5, as Bevy reads them: irradiance over pi on planes that face the six axes.
//
// The texture is nx x 2 ny x 3 nz texels. Along z stand three blocks, of planes that face along x, y and z; in each, the first ny
// rows are of planes that face the positive direction and the others of the negative one. Bevy's shader reads them so
// (irradiance_volume.wgsl); the table in its documentation has the two halves the other way round.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "export/engine/light_volume.h"
#include "export/engine/texture_3d.h"

namespace nlg {

TextureSize ambientCubesSize(const TextureSize& box_texels);

// 4 bytes a texel, little-endian. No channel is below 0.
// volume   |coefficients| <= kMaxEngineLight
std::string packAmbientCubes(const LightVolume& volume);

// bytes    4 a texel
Texture3d textureOfRgb9e5(std::string_view bytes, const TextureSize& size);

// What Bevy's shader makes of it, times pi: three linear reads, each of the side that the normal turns to, weighted by the squares of
// the normal. 0 outside the box.
// normal_3     length 1
std::array<float, kShChannels> ambientCubesIrradiance(const Texture3d& texture, const LightBox& box, const PositionM& position_m,
                                                      const float* normal_3);

}  // namespace nlg
