#include "export/engine/texture_3d.h"

#include <algorithm>
#include <cmath>

#include "export/engine/little_endian.h"
#include "runtime_eval/numbers/half.h"
#include "tool/error.h"

namespace nlg {

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

}  // namespace nlg
