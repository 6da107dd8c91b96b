// A 3-D texture as a sampler sees it: what every format of this folder is decoded to.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace nlg {

using TextureSize = std::array<uint32_t, 3>;  // texels along x, y, z
using Rgba = std::array<float, 4>;

inline constexpr uint32_t kMaxTextureSide = 2048;  // what WebGPU promises, and WebGL 2 and desktop GPUs have

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

}  // namespace nlg
