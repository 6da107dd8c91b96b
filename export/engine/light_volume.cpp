#include "export/engine/light_volume.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "runtime_eval/numbers/half.h"
#include "tool/error.h"

namespace nlg {
namespace {

std::string textOf(double number) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g", number);
  return text;
}

template <class Visit>
void forEachNeighbour(const std::array<uint32_t, 3>& count, size_t texel, const Visit& visit) {
  const size_t row = count[0], slice = row * count[1];
  const std::array<size_t, 3> at{texel % row, texel % slice / row, texel / slice};
  std::array<size_t, 3> begin, end;
  for (size_t axis = 0; axis < 3; ++axis) {
    begin[axis] = at[axis] - (at[axis] > 0 ? 1 : 0);
    end[axis] = std::min<size_t>(at[axis] + 2, count[axis]);
  }
  for (size_t z = begin[2]; z < end[2]; ++z) {
    for (size_t y = begin[1]; y < end[1]; ++y) {
      for (size_t x = begin[0]; x < end[0]; ++x) {
        const size_t neighbour = z * slice + y * row + x;
        if (neighbour != texel) visit(neighbour);
      }
    }
  }
}

enum class Texel : uint8_t { dark, next, has_light };

// Round by round: those beside texels with light take the mean of what these have.
void fillTexels(const std::array<uint32_t, 3>& count, std::vector<Texel>* texels, std::vector<float>* light) {
  std::vector<size_t> round, next;
  // a dark texel is queued once, by the first neighbour with light
  const auto findDark = [&](size_t texel) {
    forEachNeighbour(count, texel, [&](size_t neighbour) {
      if ((*texels)[neighbour] != Texel::dark) return;
      (*texels)[neighbour] = Texel::next;
      next.push_back(neighbour);
    });
  };
  for (size_t texel = 0; texel < texels->size(); ++texel) {
    if ((*texels)[texel] == Texel::has_light) findDark(texel);
  }
  while (!next.empty()) {
    round.swap(next);
    next.clear();
    // means of the rounds before alone, whatever the order of texels
    for (const size_t texel : round) {
      float neighbours = 0.0f;
      float* mean = &(*light)[texel * kShFloats];
      std::fill_n(mean, kShFloats, 0.0f);
      forEachNeighbour(count, texel, [&](size_t neighbour) {
        if ((*texels)[neighbour] != Texel::has_light) return;
        ++neighbours;
        for (size_t i = 0; i < kShFloats; ++i) mean[i] += (*light)[neighbour * kShFloats + i];
      });
      for (size_t i = 0; i < kShFloats; ++i) mean[i] /= neighbours;
    }
    for (const size_t texel : round) (*texels)[texel] = Texel::has_light;
    for (const size_t texel : round) findDark(texel);
  }
}

constexpr uint32_t kVolumes = 7, kPadding = 1;
constexpr size_t kChannels = 4;

}  // namespace

LightBox texelBox(const PositionM& low_m, const PositionM& high_m, double spacing_m) {
  std::array<double, 3> count;
  for (size_t axis = 0; axis < 3; ++axis) {
    // whole spacings stay so many where a rounding made them a little more
    count[axis] = std::max(1.0, std::ceil((high_m[axis] - low_m[axis]) / spacing_m - 1e-6));
  }
  const double texels = count[0] * count[1] * count[2];
  if (!(texels <= kMaxBoxTexels)) {
    throw UsageError("spacing_m", "one that makes at most " + std::to_string(static_cast<int>(kMaxBoxTexels)) + " texels",
                     textOf(spacing_m) + ", which makes " + textOf(count[0]) + " x " + textOf(count[1]) + " x " +
                         textOf(count[2]) + " = " + textOf(texels));
  }
  LightBox box{low_m, high_m, {}};
  for (size_t axis = 0; axis < 3; ++axis) box.texel_count[axis] = static_cast<uint32_t>(count[axis]);
  const TextureSize size = shTextureSize(box.texel_count);
  if (*std::max_element(size.begin(), size.end()) > kMaxTextureSide) {
    throw UsageError("spacing_m", "a texture of at most " + std::to_string(kMaxTextureSide) + " texels along each axis",
                     std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " + std::to_string(size[2]));
  }
  return box;
}

LightVolume filledVolume(const LightBox& box, std::vector<float> light, const std::vector<uint8_t>& has_light) {
  LightVolume volume{box, std::move(light)};
  std::vector<Texel> texels(has_light.size());
  std::transform(has_light.begin(), has_light.end(), texels.begin(),
                 [](uint8_t has) { return has != 0 ? Texel::has_light : Texel::dark; });
  if (std::find(texels.begin(), texels.end(), Texel::has_light) == texels.end()) {
    std::fill(volume.light.begin(), volume.light.end(), 0.0f);
  } else {
    fillTexels(box.texel_count, &texels, &volume.light);
  }
  return volume;
}

float largestLight(const LightVolume& volume) {
  float largest = 0.0f;
  for (const float coefficient : volume.light) largest = std::max(largest, std::abs(coefficient));
  return largest;
}

Rgba sampleLinear(const Texture3d& texture, const std::array<double, 3>& uvw) {
  std::array<size_t, 3> low, high;
  std::array<float, 3> share;
  // texel centres at halves, clamped to the edge as samplers do
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
      // padding repeats the outer slices: filtering never reaches the next volume
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

std::array<float, kShFloats> shTextureLight(const Texture3d& texture, const LightBox& box, const PositionM& position_m) {
  std::array<double, 3> at;  // texels
  for (size_t axis = 0; axis < 3; ++axis) {
    const double share = (position_m[axis] - box.low_m[axis]) / (box.high_m[axis] - box.low_m[axis]);
    at[axis] = std::clamp(share * box.texel_count[axis], 0.5, box.texel_count[axis] - 0.5);
  }
  std::array<float, kShFloats> light;
  for (size_t v = 0; v < kVolumes; ++v) {
    const double z = at[2] + kPadding + static_cast<double>(v * (box.texel_count[2] + 2 * kPadding));
    const Rgba four = sampleLinear(texture, {at[0] / texture.size[0], at[1] / texture.size[1], z / texture.size[2]});
    std::copy_n(four.begin(), std::min(kChannels, light.size() - v * kChannels), &light[v * kChannels]);
  }
  return light;
}

}  // namespace nlg
