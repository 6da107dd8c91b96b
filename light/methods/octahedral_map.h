// Functions of directions as square maps, by the octahedral mapping: the form in which DDGI stores irradiance and depth.
//
// A map of N x N texels; beyond its rim lies what the mapping says, as RTXGI's border texels have it. Cigolle and others, "A survey of
// efficient representations for independent unit vectors" (JCGT 2014).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/glm.hpp>

namespace nlg {

// On [-1, 1]².
inline glm::vec2 octahedralPlace(const glm::vec3& direction) {
  const glm::vec3 d = direction / (std::fabs(direction.x) + std::fabs(direction.y) + std::fabs(direction.z));
  if (d.z >= 0.0f) return {d.x, d.y};
  return {std::copysign(1.0f - std::fabs(d.y), d.x), std::copysign(1.0f - std::fabs(d.x), d.y)};
}

inline glm::vec3 octahedralDirection(const glm::vec2& place) {
  glm::vec3 d(place.x, place.y, 1.0f - std::fabs(place.x) - std::fabs(place.y));
  if (d.z < 0.0f) {
    const glm::vec3 folded(std::copysign(1.0f - std::fabs(d.y), d.x), std::copysign(1.0f - std::fabs(d.x), d.y), d.z);
    d = folded;
  }
  return glm::normalize(d);
}

template <class Texel, int kSide>
struct OctahedralMap {
  static constexpr int kTexelCount = kSide * kSide;
  std::array<Texel, kTexelCount> texels{};

  // Of a texel's centre.
  static glm::vec3 direction(int texel) {
    const auto centre = [](int i) { return (2.0f * static_cast<float>(i) + 1.0f) / kSide - 1.0f; };
    return octahedralDirection({centre(texel % kSide), centre(texel / kSide)});
  }

  // x, y in [-1, kSide]
  const Texel& wrapped(int x, int y) const {
    if (x < 0 || x >= kSide) {
      x = x < 0 ? 0 : kSide - 1;
      y = kSide - 1 - y;
    }
    if (y < 0 || y >= kSide) {
      y = y < 0 ? 0 : kSide - 1;
      x = kSide - 1 - x;
    }
    return texels[y * kSide + x];
  }

  // Bilinear between texel centres.
  Texel at(const glm::vec3& direction) const {
    const glm::vec2 place = (octahedralPlace(direction) * 0.5f + 0.5f) * static_cast<float>(kSide) - 0.5f;
    const int x = std::clamp(static_cast<int>(std::floor(place.x)), -1, kSide - 1);
    const int y = std::clamp(static_cast<int>(std::floor(place.y)), -1, kSide - 1);
    const float sx = place.x - static_cast<float>(x), sy = place.y - static_cast<float>(y);
    return (wrapped(x, y) * (1.0f - sx) + wrapped(x + 1, y) * sx) * (1.0f - sy) +
           (wrapped(x, y + 1) * (1.0f - sx) + wrapped(x + 1, y + 1) * sx) * sy;
  }
};

}  // namespace nlg
