#include "runtime_eval/numbers/half.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace nlg {
namespace {

constexpr uint16_t kOneBelowInfinity = 0x7bff;

float asFloat(uint32_t bits) { return floatFromHalf({static_cast<uint16_t>(bits)}); }

// The bits of a value that must be in range.
uint32_t asHalf(float value) {
  Half half;
  EXPECT_TRUE(halfFromFloat(value, &half)) << value;
  return half.bits;
}

// By the definition of binary16, in double.
double exactValue(uint32_t bits) {
  const int exponent = static_cast<int>(bits >> 10 & 31);
  const double mantissa = bits & 0x3ff;
  const double magnitude = exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024.0 + mantissa, exponent - 25);
  return bits >> 15 ? -magnitude : magnitude;
}

TEST(Half, IsExactlyWhatItsBitsSay) {
  for (uint32_t bits = 0; bits < 0x10000; ++bits) {
    if ((bits >> 10 & 31) == 31) continue;
    ASSERT_EQ(double{asFloat(bits)}, exactValue(bits)) << std::hex << bits;
    ASSERT_EQ(std::signbit(asFloat(bits)), bits >> 15 == 1) << std::hex << bits;
  }
  EXPECT_EQ(asFloat(0x7c00), std::numeric_limits<float>::infinity());
  EXPECT_EQ(asFloat(0xfc00), -std::numeric_limits<float>::infinity());
  for (uint32_t bits = 0x7c01; bits < 0x8000; ++bits) ASSERT_TRUE(std::isnan(asFloat(bits))) << std::hex << bits;
}

TEST(Half, ReturnsFromFloatUnchanged) {
  for (uint32_t bits = 0; bits < 0x10000; ++bits) {
    Half half{0x1234};
    const bool is_finite = (bits >> 10 & 31) != 31;
    ASSERT_EQ(halfFromFloat(asFloat(bits), &half), is_finite) << std::hex << bits;
    ASSERT_EQ(half.bits, is_finite ? bits : 0x1234u);
  }
}

TEST(Half, RoundsToTheNearestAndTiesToEven) {
  // between each two neighbours: the middle goes to the even one, a float next to the middle to the nearer one
  for (uint32_t low = 0; low < kOneBelowInfinity; ++low) {
    const float middle = static_cast<float>((exactValue(low) + exactValue(low + 1)) / 2);
    const uint32_t even = low + (low & 1);
    ASSERT_EQ(asHalf(middle), even) << std::hex << low;
    ASSERT_EQ(asHalf(-middle), even | 0x8000u) << std::hex << low;
    ASSERT_EQ(asHalf(std::nextafter(middle, 0.0f)), low) << std::hex << low;
    ASSERT_EQ(asHalf(std::nextafter(middle, 1e9f)), low + 1) << std::hex << low;
  }
}

TEST(Half, RefusesWhatItCannotHold) {
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float value : {std::nextafter(kMaxHalf, infinity), 65519.0f, 65520.0f, 1e30f, infinity, std::nanf("")}) {
    Half half{0x1234};
    EXPECT_FALSE(halfFromFloat(value, &half)) << value;
    EXPECT_FALSE(halfFromFloat(-value, &half)) << value;
    EXPECT_EQ(half.bits, 0x1234) << value;
  }
  EXPECT_EQ(asHalf(kMaxHalf), kOneBelowInfinity);
}

}  // namespace
}  // namespace nlg
