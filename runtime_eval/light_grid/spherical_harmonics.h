// Real spherical harmonics up to order 2, and what they say of irradiance.
//
// Coefficients are those of radiance over directions that light comes from; a coefficient is the mean over the sphere of radiance
// times basis function, times 4 pi. Order of the 9: Y00, Y1-1 (y), Y10 (z), Y11 (x), Y2-2 (xy), Y2-1 (yz), Y20 (3z²-1),
// Y21 (xz), Y22 (x²-y²). Irradiance by Ramamoorthi and Hanrahan, "An efficient representation for irradiance environment maps"
// (SIGGRAPH 2001): each band times pi, 2 pi / 3, pi / 4.
#pragma once

#include <array>

namespace nlg {

inline constexpr int kShCount = 9;     // coefficients of order 2
inline constexpr int kShChannels = 3;  // red, green, blue
inline constexpr int kShFloats = kShCount * kShChannels;

// What irradiance takes of each coefficient's band.
inline constexpr std::array<float, kShCount> kCosineBand = {3.14159265f, 2.09439510f, 2.09439510f, 2.09439510f, 0.78539816f,
                                                            0.78539816f, 0.78539816f, 0.78539816f, 0.78539816f};

// The basis functions at a direction of length 1.
constexpr std::array<float, kShCount> shBasis(float x, float y, float z) {
  return {0.28209479f,
          0.48860251f * y,
          0.48860251f * z,
          0.48860251f * x,
          1.09254843f * x * y,
          1.09254843f * y * z,
          0.31539157f * (3.0f * z * z - 1.0f),
          1.09254843f * x * z,
          0.54627422f * (x * x - y * y)};
}

// Irradiance on a plane that faces (x, y, z), length 1, from coefficients: 9 of red, green, blue each. It may fall below 0 where
// light is harsh: whoever shows it clamps it.
inline std::array<float, kShChannels> shIrradiance(const float* light_9x3, float x, float y, float z) {
  const std::array<float, kShCount> basis = shBasis(x, y, z);
  std::array<float, kShChannels> rgb{};
  for (int i = 0; i < kShCount; ++i) {
    for (int c = 0; c < kShChannels; ++c) rgb[c] += kCosineBand[i] * basis[i] * light_9x3[i * kShChannels + c];
  }
  return rgb;
}

}  // namespace nlg
