// Spherical harmonics in one 3-D texture of four float16 a texel: what three.js reads, and what KTX2 files hold here.
//
// Seven volumes stand one behind the other along z. Texel (x, y, z) of the box is texel (x, y, z + 1) of each of them; the first
// and the last slice of a volume are once more those beside them, so that a linear filter stays inside its volume. The 27
// coefficients of a texel, red, green and blue of each in the order of spherical_harmonics.h, are red, green, blue and alpha of
// the first volume, then of the second, and so on; the last alpha is 0. The texture is nx x ny x 7 (nz + 2) texels.
#pragma once

#include <array>
#include <string>

#include "export/engine/light_volume.h"
#include "export/engine/texture_3d.h"

namespace nlg {

TextureSize shTextureSize(const TextureSize& box_texels);

// 8 bytes a texel, little-endian.
// volume   |coefficients| <= kMaxEngineLight
std::string packShTexture(const LightVolume& volume);

// What a shader makes of it: seven linear reads, and irradiance by spherical_harmonics.h, no channel below 0. Outside the box, its
// faces' light.
// position_m   finite
// normal_3     length 1
std::array<float, kShChannels> shTextureIrradiance(const Texture3d& texture, const LightBox& box, const PositionM& position_m,
                                                   const float* normal_3);

}  // namespace nlg
