// Images of a scene's surfaces, at reduced size.
//
// Diffuse light needs a texel for every few centimetres of wall, and no more: an image is kept with at most kMostTexelsOfSide on a
// side, as means over its pixels in linear light.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace nlg {

inline constexpr int kMostTexelsOfSide = 512;

struct TextureImage {
  int width = 0, height = 0;                   // 1 … kMostTexelsOfSide each
  std::vector<std::array<uint8_t, 4>> texels;  // width x height, rows from the top: red, green, blue as sRGB codes, opacity * 255
};

enum class TextureWrap : uint8_t { repeat, mirror, clamp };

// How a material uses an image.
struct TextureUse {
  int32_t image = -1;  // of the scene's; -1: none
  TextureWrap wrap_u = TextureWrap::repeat, wrap_v = TextureWrap::repeat;

  bool isThere() const { return image >= 0; }
};

// Linear colour (each channel in [0, 1]) and opacity at a place, bilinear between texels, whose centres stand at halves.
// place   (0, 0) is the upper left corner of the image, (1, 1) the lower right one; any finite numbers
glm::vec4 texelAt(const TextureImage& image, const TextureUse& use, const glm::vec2& place);

// Linear light of an sRGB code, and the nearest code of linear light (clamped to [0, 1]).
float linearFromSrgb(uint8_t code);
uint8_t srgbFromLinear(double linear);

}  // namespace nlg
