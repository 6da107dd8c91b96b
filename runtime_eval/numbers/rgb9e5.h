// Three numbers with one exponent, in 32 bits: 9 bits of red, green and blue from the lowest on, 5 of the exponent above. What
// Vulkan calls E5B9G9R9_UFLOAT_PACK32, Direct3D R9G9B9E5_SHAREDEXP, OpenGL RGB9_E5 (EXT_texture_shared_exponent).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace nlg {

inline constexpr float kMaxRgb9e5 = 65408.0f;  // 511 / 512 * 2^16

// Rounds to nearest; what is below 0 or no number becomes 0, what is above kMaxRgb9e5 becomes that. The error of each number is at
// most a 512th of the power of two above the largest of the three.
inline uint32_t rgb9e5(float red, float green, float blue) {
  constexpr int kBias = 15, kBits = 9;
  const auto clamped = [](float value) { return value > 0.0f ? std::min(value, kMaxRgb9e5) : 0.0f; };
  const std::array<float, 3> rgb = {clamped(red), clamped(green), clamped(blue)};
  const float largest = std::max({rgb[0], rgb[1], rgb[2]});
  int power = 0;  // largest < 2^power
  std::frexp(largest, &power);
  int exponent = largest > 0.0f ? std::max(power + kBias, 0) : 0;
  const auto steps = [&](float value) { return std::lround(std::ldexp(value, kBias + kBits - exponent)); };
  if (steps(largest) == 1 << kBits) ++exponent;
  return static_cast<uint32_t>(steps(rgb[0])) | static_cast<uint32_t>(steps(rgb[1])) << 9 |
         static_cast<uint32_t>(steps(rgb[2])) << 18 | static_cast<uint32_t>(exponent) << 27;
}

inline std::array<float, 3> fromRgb9e5(uint32_t word) {
  const auto part = [&](int shift) {
    return std::ldexp(static_cast<float>(word >> shift & 511u), static_cast<int>(word >> 27) - 24);
  };
  return {part(0), part(9), part(18)};
}

}  // namespace nlg
