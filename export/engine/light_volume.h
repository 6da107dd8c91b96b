// Light in a box of texels, the source of all texture formats of this folder.
//
// Texels in solid hold no light of their own. A linear filter reads them all the same beside walls, and three.js half a texel further:
// they are filled from their neighbours, outwards from where light is.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "nlg/look_up.h"

namespace nlg {

inline constexpr double kMaxBoxTexels = 1 << 23;   // of a box: 470 MB of float16
inline constexpr uint32_t kMaxTextureSide = 2048;  // what WebGPU promises, and WebGL 2 and desktop GPUs have

// Texels that fill a box: as few along each axis as are no wider than the spacing.
// spacing_m   > 0
// throws      UsageError naming spacing_m where the texels would be more than kMaxBoxTexels, with their count, or a side of their
//             texture above kMaxTextureSide
LightBox texelBox(const PositionM& low_m, const PositionM& high_m, double spacing_m);

struct LightVolume {
  LightBox box;
  std::vector<float> light;  // kShFloats a texel: radiance as spherical harmonics; x is the fastest index
};

// Round by round, texels beside those with light take the mean of what these have. Where none has light, all are 0.
// light       kShFloats a texel
// has_light   by texel
LightVolume filledVolume(const LightBox& box, std::vector<float> light, const std::vector<uint8_t>& has_light);

// The largest |coefficient|.
float largestLight(const LightVolume& volume);

// Spherical harmonics in one 3-D texture with four float16 per texel, for three.js and KTX2 files.
//
// Seven volumes stand one behind the other along z. Texel (x, y, z) of the box is texel (x, y, z + 1) of each of them; the first
// and the last slice of a volume are once more those beside them, so that a linear filter stays inside its volume. The 27
// coefficients of a texel, red, green and blue of each in the order of nlg/light_grid.h, are red, green, blue and alpha of
// the first volume, then of the second, and so on; the last alpha is 0. The texture is nx x ny x 7 (nz + 2) texels.

// Numbers as little-endian bytes, and back: the same on every machine.
//
// byte_count   1 … 8, of the number's lowest bytes
inline void appendNumber(uint64_t number, size_t byte_count, std::string* bytes) {
  for (size_t i = 0; i < byte_count; ++i) bytes->push_back(static_cast<char>(number >> 8 * i & 0xff));
}

// place        place + byte_count <= bytes.size()
inline uint64_t numberAt(std::string_view bytes, size_t place, size_t byte_count) {
  uint64_t number = 0;
  for (size_t i = 0; i < byte_count; ++i) number |= uint64_t{static_cast<uint8_t>(bytes[place + i])} << 8 * i;
  return number;
}

// A 3-D texture as a sampler sees it: what every format of this folder is decoded to.
using TextureSize = std::array<uint32_t, 3>;  // texels along x, y, z
using Rgba = std::array<float, 4>;

inline size_t texelsOf(const TextureSize& size) { return size_t{size[0]} * size[1] * size[2]; }

struct Texture3d {
  TextureSize size{};
  std::vector<Rgba> texels;  // x is the fastest index, z the slowest
};

// The linear filter of GPUs, clamped to the edge: texel i of n along an axis has its centre at (i + .5) / n.
// texture   of one texel or more
// uvw       finite; the texture is [0, 1]³
Rgba sampleLinear(const Texture3d& texture, const std::array<double, 3>& uvw);

// RGBA of four float16 a texel, little-endian.
// bytes     8 a texel
Texture3d textureOfHalves(std::string_view bytes, const TextureSize& size);

TextureSize shTextureSize(const TextureSize& box_texels);

// 8 bytes a texel, little-endian.
// volume   |coefficients| <= kMaxEngineLight
std::string packShTexture(const LightVolume& volume);

// What a shader reads of it: seven linear reads. Outside the box, its faces' light.
// position_m   finite
std::array<float, kShFloats> shTextureLight(const Texture3d& texture, const LightBox& box, const PositionM& position_m);

}  // namespace nlg
