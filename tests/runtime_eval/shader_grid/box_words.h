// A box as the uniform block of resample.comp has it.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "runtime_eval/light_grid/resampled_light.h"

namespace nlg {

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
