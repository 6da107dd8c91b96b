#include "scene/model/texture_image.h"

#include <algorithm>
#include <cmath>

namespace nlg {
namespace {

double linearOf(double s) { return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4); }

const std::array<float, 256>& linearOfCodes() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> linear{};
    for (size_t code = 0; code < linear.size(); ++code)
      linear[code] = static_cast<float>(linearOf(static_cast<double>(code) / 255.0));
    return linear;
  }();
  return table;
}

// The texel that a whole number beyond the image's rim stands for.
int wrapped(int at, int side, TextureWrap wrap) {
  if (at >= 0 && at < side) return at;
  if (wrap == TextureWrap::clamp) return std::clamp(at, 0, side - 1);
  const int period = wrap == TextureWrap::mirror ? 2 * side : side;
  const int within = (at % period + period) % period;
  return within < side ? within : period - 1 - within;
}

// The two texels around a place, and how far the place is on the way to the second.
struct Between {
  int low, high;
  float share;
};

Between betweenTexels(float place, int side, TextureWrap wrap) {
  // whole turns away: a float has few digits left for the texel of a place far out, and an int none
  const float turn = wrap == TextureWrap::clamp ? 0.0f : 2.0f * std::floor(0.5f * place);
  const float near = std::clamp(place - turn, -4.0f, 4.0f);
  const float at = near * static_cast<float>(side) - 0.5f;
  const float low = std::floor(at);
  const int first = static_cast<int>(low);
  return {wrapped(first, side, wrap), wrapped(first + 1, side, wrap), at - low};
}

}  // namespace

glm::vec4 texelAt(const TextureImage& image, const TextureUse& use, const glm::vec2& place) {
  const std::array<float, 256>& linear = linearOfCodes();
  const Between x = betweenTexels(place.x, image.width, use.wrap_u), y = betweenTexels(place.y, image.height, use.wrap_v);
  const auto texel = [&](int column, int row) {
    const std::array<uint8_t, 4>& codes = image.texels[static_cast<size_t>(row) * image.width + column];
    return glm::vec4(linear[codes[0]], linear[codes[1]], linear[codes[2]], static_cast<float>(codes[3]) / 255.0f);
  };
  // a + share (b - a): of equal texels exactly their colour
  const auto mixed = [](const glm::vec4& a, const glm::vec4& b, float share) { return a + share * (b - a); };
  return mixed(mixed(texel(x.low, y.low), texel(x.high, y.low), x.share),
               mixed(texel(x.low, y.high), texel(x.high, y.high), x.share), y.share);
}

float linearFromSrgb(uint8_t code) { return linearOfCodes()[code]; }

uint8_t srgbFromLinear(double linear) {
  // where each code's share of linear light ends; a power for each of millions of texels takes longer than decoding them
  static const std::array<double, 255> ends = [] {
    std::array<double, 255> table{};
    for (size_t code = 0; code < table.size(); ++code) table[code] = linearOf((static_cast<double>(code) + 0.5) / 255.0);
    return table;
  }();
  static const std::array<uint8_t, 4097> first = [] {
    std::array<uint8_t, 4097> table{};
    for (size_t i = 0; i < table.size(); ++i) {
      const auto end = std::upper_bound(ends.begin(), ends.end(), static_cast<double>(i) / 4096.0);
      table[i] = static_cast<uint8_t>(end - ends.begin());
    }
    return table;
  }();
  const double l = std::clamp(linear, 0.0, 1.0);
  size_t code = first[static_cast<size_t>(4096.0 * l)];
  while (code < ends.size() && ends[code] <= l) ++code;
  return static_cast<uint8_t>(code);
}

}  // namespace nlg
