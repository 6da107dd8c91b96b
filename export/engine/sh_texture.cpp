#include "export/engine/sh_texture.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/numbers/half.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr uint32_t kVolumes = 7, kPadding = 1;
constexpr size_t kChannels = 4;

}  // namespace

Rgba sampleLinear(const Texture3d& texture, const std::array<double, 3>& uvw) {
  std::array<size_t, 3> low, high;
  std::array<float, 3> share;
  for (size_t axis = 0; axis < 3; ++axis) {
    const double last = texture.size[axis] - 1.0, at = std::clamp(uvw[axis] * texture.size[axis] - 0.5, 0.0, last);
    low[axis] = static_cast<size_t>(at);
    high[axis] = std::min(low[axis] + 1, size_t{texture.size[axis]} - 1);
    share[axis] = static_cast<float>(at - std::floor(at));
  }
  Rgba sum{};
  for (unsigned corner = 0; corner < 8; ++corner) {
    float part = 1.0f;
    std::array<size_t, 3> texel;
    for (size_t axis = 0; axis < 3; ++axis) {
      const bool is_high = (corner >> axis & 1) != 0;
      part *= is_high ? share[axis] : 1.0f - share[axis];
      texel[axis] = is_high ? high[axis] : low[axis];
    }
    const Rgba& value = texture.texels[(texel[2] * texture.size[1] + texel[1]) * texture.size[0] + texel[0]];
    for (size_t c = 0; c < value.size(); ++c) sum[c] += part * value[c];
  }
  return sum;
}

Texture3d textureOfHalves(std::string_view bytes, const TextureSize& size) {
  Texture3d texture{size, std::vector<Rgba>(texelsOf(size))};
  constexpr size_t kHalf = sizeof(uint16_t);
  NLG_CHECK(bytes.size(), ==, 4 * kHalf * texture.texels.size());
  size_t place = 0;
  for (Rgba& texel : texture.texels) {
    for (float& channel : texel) {
      channel = floatFromHalf({static_cast<uint16_t>(numberAt(bytes, place, kHalf))});
      place += kHalf;
    }
  }
  return texture;
}

TextureSize shTextureSize(const TextureSize& box_texels) {
  return {box_texels[0], box_texels[1], kVolumes * (box_texels[2] + 2 * kPadding)};
}

std::string packShTexture(const LightVolume& volume) {
  const TextureSize& count = volume.box.texel_count;
  const size_t slice = size_t{count[0]} * count[1];
  std::string bytes;
  bytes.reserve(texelsOf(shTextureSize(count)) * kChannels * sizeof(uint16_t));
  for (size_t v = 0; v < kVolumes; ++v) {
    for (uint32_t padded = 0; padded < count[2] + 2 * kPadding; ++padded) {
      const size_t z = std::clamp(padded, kPadding, count[2]) - kPadding;
      for (size_t texel = z * slice; texel < (z + 1) * slice; ++texel) {
        for (size_t number = v * kChannels; number < (v + 1) * kChannels; ++number) {
          Half half;
          if (number < kShFloats) NLG_CHECK(halfFromFloat(volume.light[texel * kShFloats + number], &half), ==, true);
          appendNumber(half.bits, sizeof(uint16_t), &bytes);
        }
      }
    }
  }
  return bytes;
}

std::array<float, kShChannels> shTextureIrradiance(const Texture3d& texture, const LightBox& box, const PositionM& position_m,
                                                   const float* normal_3) {
  std::array<double, 3> at;  // texels
  for (size_t axis = 0; axis < 3; ++axis) {
    const double share = (position_m[axis] - box.low_m[axis]) / (box.high_m[axis] - box.low_m[axis]);
    at[axis] = std::clamp(share * box.texel_count[axis], 0.5, box.texel_count[axis] - 0.5);
  }
  float light[kVolumes * kChannels];
  for (size_t v = 0; v < kVolumes; ++v) {
    const double z = at[2] + kPadding + static_cast<double>(v * (box.texel_count[2] + 2 * kPadding));
    const Rgba four = sampleLinear(texture, {at[0] / texture.size[0], at[1] / texture.size[1], z / texture.size[2]});
    std::copy(four.begin(), four.end(), &light[v * kChannels]);
  }
  std::array<float, kShChannels> rgb = shIrradiance(light, normal_3[0], normal_3[1], normal_3[2]);
  for (float& channel : rgb) channel = std::max(0.0f, channel);
  return rgb;
}

}  // namespace nlg
