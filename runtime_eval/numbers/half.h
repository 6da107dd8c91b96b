// Converts float16 (IEEE 754 binary16) by integer arithmetic: the same bits on every machine.
#pragma once

#include <bit>
#include <cstdint>

namespace nlg {

struct Half {
  uint16_t bits = 0;
  bool operator==(const Half&) const = default;
};

inline constexpr float kMaxHalf = 65504.0f;

// Rounds to the nearest half, ties to even; small values become denormal halves or a zero of the same sign.
// returns   false, *half unchanged, when |value| > kMaxHalf or value is not a number
inline bool halfFromFloat(float value, Half* half) {
  const uint32_t bits = std::bit_cast<uint32_t>(value);
  const uint32_t magnitude = bits & 0x7fffffffu, exponent = magnitude >> 23;
  if (magnitude > std::bit_cast<uint32_t>(kMaxHalf)) return false;
  // scaled / 2^shift is the result's bits before rounding: exponent and mantissa are one integer, so a carry is right by itself
  uint32_t scaled = magnitude - (112u << 23), shift = 13;
  if (exponent < 113) {  // below 2^-14: units of 2^-24; what is less than half of one is shifted out
    scaled = (magnitude & 0x7fffffu) | (exponent > 0 ? 0x800000u : 0u);
    shift = exponent > 101 ? 126 - exponent : 25;
  }
  const uint32_t is_odd = scaled >> shift & 1;
  const uint32_t rounded = (scaled + (1u << (shift - 1)) - 1 + is_odd) >> shift;
  half->bits = static_cast<uint16_t>((bits >> 16 & 0x8000u) | rounded);
  return true;
}

// Exact; infinities and NaN stay what they are.
inline float floatFromHalf(Half half) {
  const uint32_t sign = (half.bits & 0x8000u) << 16, exponent = half.bits >> 10 & 31, mantissa = half.bits & 0x3ffu;
  if (exponent == 31) return std::bit_cast<float>(sign | 0x7f800000u | mantissa << 13);
  if (exponent > 0) return std::bit_cast<float>(sign | (exponent + 112) << 23 | mantissa << 13);
  const float magnitude = static_cast<float>(mantissa) * 0x1p-24f;
  return sign != 0 ? -magnitude : magnitude;
}

}  // namespace nlg
