// Places to look a grid up at, as shaders have them, and what lookUpIrradiance says there.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "nlg/look_up.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {

inline std::array<float, 3> randomNormal(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal(), length = std::sqrt(x * x + y * y + z * z);
  return {static_cast<float>(x / length), static_cast<float>(y / length), static_cast<float>(z / length)};
}

inline PositionM asFloats(const PositionM& position_m) {
  PositionM rounded;
  for (size_t axis = 0; axis < 3; ++axis) rounded[axis] = static_cast<float>(position_m[axis]);
  return rounded;
}

struct ShaderPlaces {
  std::vector<PositionM> positions_m;  // floats
  std::vector<std::array<float, 3>> normals;

  size_t count() const { return positions_m.size(); }

  // 8 floats a place: position, 0, normal, 0.
  std::vector<uint32_t> words() const {
    std::vector<uint32_t> words;
    words.reserve(8 * count());
    for (size_t i = 0; i < count(); ++i) {
      for (const double value : positions_m[i]) words.push_back(std::bit_cast<uint32_t>(static_cast<float>(value)));
      words.push_back(0);
      for (const float value : normals[i]) words.push_back(std::bit_cast<uint32_t>(value));
      words.push_back(0);
    }
    return words;
  }
};

// 4 floats a place: irradiance, status.
inline std::vector<float> lightAt(const LightGrid& grid, const ShaderPlaces& places) {
  std::vector<float> light(4 * places.count());
  for (size_t i = 0; i < places.count(); ++i)
    light[4 * i + 3] = static_cast<float>(lookUpIrradiance(grid, places.positions_m[i], places.normals[i].data(), &light[4 * i]));
  return light;
}

}  // namespace nlg
