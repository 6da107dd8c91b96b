// Packs three numbers into 32 bits with a shared exponent (EXT_texture_shared_exponent, Vulkan, WebGPU): red in bits 0 to 8,
// green in 9 to 17, blue in 18 to 26, the exponent above; a channel is its 9 bits times 2^(exponent - 24).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace nlg {

inline constexpr float kMaxRgb9e5 = 65408.0f;  // 511 * 2^7

// Rounds to nearest: every channel is off by at most 2^-9 of the largest one, or 2^-25.
// rgb   in [0, kMaxRgb9e5]
inline uint32_t rgb9e5FromFloats(const std::array<float, 3>& rgb) {
  const float largest = std::max({rgb[0], rgb[1], rgb[2]});
  int exponent = largest > 0.0f ? std::max(-16, std::ilogb(largest)) + 16 : 0;
  const auto bitsOf = [&](float channel) { return static_cast<uint32_t>(std::floor(std::ldexp(channel, 24 - exponent) + 0.5f)); };
  if (bitsOf(largest) == 512) ++exponent;  // rounded up to the next power of two
  return bitsOf(rgb[0]) | bitsOf(rgb[1]) << 9 | bitsOf(rgb[2]) << 18 | static_cast<uint32_t>(exponent) << 27;
}

}  // namespace nlg
