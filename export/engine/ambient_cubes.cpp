#include "export/engine/ambient_cubes.h"

#include <algorithm>

#include "export/engine/little_endian.h"
#include "runtime_eval/numbers/rgb9e5.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr float kPi = 3.14159265f;

std::array<float, 3> cubeSide(const float* light_9x3, size_t axis, bool is_negative) {
  std::array<float, 3> normal{};
  normal[axis] = is_negative ? -1.0f : 1.0f;
  std::array<float, 3> rgb = shIrradiance(light_9x3, normal[0], normal[1], normal[2]);
  for (float& channel : rgb) channel = std::max(0.0f, channel / kPi);
  return rgb;
}

}  // namespace

TextureSize ambientCubesSize(const TextureSize& box_texels) { return {box_texels[0], 2 * box_texels[1], 3 * box_texels[2]}; }

std::string packAmbientCubes(const LightVolume& volume) {
  const TextureSize& count = volume.box.texel_count;
  const size_t row = count[0], slice = row * count[1];
  std::string bytes;
  bytes.reserve(texelsOf(ambientCubesSize(count)) * sizeof(uint32_t));
  for (size_t axis = 0; axis < 3; ++axis) {
    for (size_t z = 0; z < count[2]; ++z) {
      for (const bool is_negative : {false, true}) {
        for (size_t texel = z * slice; texel < (z + 1) * slice; ++texel) {
          const std::array<float, 3> side = cubeSide(&volume.light[texel * kShFloats], axis, is_negative);
          NLG_CHECK(std::max({side[0], side[1], side[2]}), <=, kMaxRgb9e5);
          appendNumber(rgb9e5FromFloats(side), sizeof(uint32_t), &bytes);
        }
      }
    }
  }
  return bytes;
}

Texture3d textureOfRgb9e5(std::string_view bytes, const TextureSize& size) {
  Texture3d texture{size, std::vector<Rgba>(texelsOf(size))};
  NLG_CHECK(bytes.size(), ==, sizeof(uint32_t) * texture.texels.size());
  for (size_t i = 0; i < texture.texels.size(); ++i) {
    const std::array<float, 3> rgb =
        floatsFromRgb9e5(static_cast<uint32_t>(numberAt(bytes, i * sizeof(uint32_t), sizeof(uint32_t))));
    texture.texels[i] = {rgb[0], rgb[1], rgb[2], 1.0f};
  }
  return texture;
}

std::array<float, kShChannels> ambientCubesIrradiance(const Texture3d& texture, const LightBox& box, const PositionM& position_m,
                                                      const float* normal_3) {
  std::array<double, 3> uvw;
  for (size_t axis = 0; axis < 3; ++axis) {
    const double share = (position_m[axis] - box.low_m[axis]) / (box.high_m[axis] - box.low_m[axis]);
    if (!(share >= 0.0 && share <= 1.0)) return {};
    uvw[axis] = std::clamp(share * box.texel_count[axis], 0.5, box.texel_count[axis] - 0.5) / texture.size[axis];
  }
  std::array<float, kShChannels> rgb{};
  for (size_t axis = 0; axis < 3; ++axis) {
    const double half = normal_3[axis] < 0.0f ? 0.5 : 0.0;
    const Rgba side = sampleLinear(texture, {uvw[0], uvw[1] + half, uvw[2] + static_cast<double>(axis) / 3.0});
    for (size_t c = 0; c < rgb.size(); ++c) rgb[c] += kPi * normal_3[axis] * normal_3[axis] * side[c];
  }
  return rgb;
}

}  // namespace nlg
