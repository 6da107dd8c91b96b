// Places all over a grid, as shaders have them, and what lookUpIrradiance says there.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "runtime_eval/light_grid/irradiance.h"
#include "tests/runtime_eval/shader_grid/every_representation.h"

namespace nlg {

struct Places {
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

inline Places randomPlaces(const LightGrid& grid, size_t count, uint64_t seed) {
  Random random(seed);
  Places places;
  for (size_t i = 0; i < count; ++i) {
    places.positions_m.push_back(randomPlace(grid.tree.frame(), random));
    places.normals.push_back(randomNormal(random));
  }
  return places;
}

// 4 floats a place: irradiance, status.
inline std::vector<float> lightAt(const LightGrid& grid, const Places& places) {
  std::vector<float> light(4 * places.count());
  for (size_t i = 0; i < places.count(); ++i)
    light[4 * i + 3] = static_cast<float>(lookUpIrradiance(grid, places.positions_m[i], places.normals[i].data(), &light[4 * i]));
  return light;
}

}  // namespace nlg
