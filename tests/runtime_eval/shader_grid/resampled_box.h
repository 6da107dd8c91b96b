// A box around a grid, and what resample.comp should make of it.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "nlg/look_up.h"

namespace nlg {

inline constexpr size_t kSlabs = 7, kTexelNumbers = 4 * kSlabs;

// The whole tree and a rim. Centres are exact in float, at odd 16ths, 32nds and 64ths of a unit along x, y and z: in no face
// between two, and never as near to one cell as to another.
inline LightBox boxOf(const ProbeTreeFrame& frame) {
  LightBox box;
  box.texel_count = {50, 27, 49};
  for (size_t axis = 0; axis < 3; ++axis) {
    box.low_m[axis] = frame.first_m[axis] - 1.0 + 1.0 / (32 << axis);
    box.high_m[axis] = box.low_m[axis] + 1.375 * box.texel_count[axis];
  }
  return box;
}

// kTexelNumbers a texel, x the fastest: radiance times its say, then that say.
inline std::vector<float> texelNumbers(const LightGrid& grid, const LightBox& box) {
  LookUpScratch scratch;
  const ResampledLight resampled = resampleLight(grid, box, &scratch);
  std::vector<float> numbers;
  for (size_t texel = 0; texel < box.texelCount(); ++texel) {
    ProbeWeights shares;
    lookUpShares(grid, box.texelCentre(texel), &shares);
    const float* light = &resampled.light[kShFloats * texel];
    const bool has_light = std::any_of(light, light + kShChannels, [](float value) { return value != 0.0f; });
    const float say = has_light ? std::max(shares.certainty, 1.0f / 256.0f) : 0.0f;
    for (int i = 0; i < kShFloats; ++i) numbers.push_back(say * light[i]);
    numbers.push_back(say);
  }
  return numbers;
}

// A box as the uniform block of resample.comp has it.
inline std::vector<uint32_t> boxWords(const LightBox& box) {
  std::vector<uint32_t> words(12);
  for (size_t axis = 0; axis < 3; ++axis) {
    const double texel_m = (box.high_m[axis] - box.low_m[axis]) / box.texel_count[axis];
    words[axis] = std::bit_cast<uint32_t>(static_cast<float>(box.low_m[axis]));
    words[4 + axis] = std::bit_cast<uint32_t>(static_cast<float>(texel_m));
    words[8 + axis] = box.texel_count[axis];
  }
  return words;
}

// Groups of 4³ texels that cover a box.
inline std::array<uint32_t, 3> boxGroups(const LightBox& box) {
  return {(box.texel_count[0] + 3) / 4, (box.texel_count[1] + 3) / 4, (box.texel_count[2] + 3) / 4};
}

}  // namespace nlg
