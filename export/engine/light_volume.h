// Resamples the light of a grid into a box of texels, the source of all texture formats of this folder.
//
// Texels where the grid gives no light stand in solid or where nobody needs light. A linear filter reads them all the same beside
// walls, and three.js half a texel further: they are filled from their neighbours, outwards from where light is. Outside of all
// cells the grid's own light of the nearest cell within a unit comes first: with it the textures of four scenes were up to a
// seventh less wrong.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "nlg/look_up.h"

namespace nlg {

inline constexpr double kMaxTexels = 1 << 23;   // of a box: 470 MB of float16
inline constexpr double kDefaultSpacing = 0.5;  // of a texel, in units of the grid

struct VolumeOptions {
  std::vector<std::string> extent_m;  // low and high corner, metres; none: the used cells and a texel on every side
  double spacing_m = 0.0;             // no texel is wider; 0: kDefaultSpacing units
};

// The box, and texels that fill it: as few along each axis as are no wider than the spacing.
// grid     with one used cell or more
// throws   UsageError naming extent_m unless its texts are six finite numbers, low below high; naming spacing_m where the texels
//          would be more than kMaxTexels, with their count
LightBox volumeBox(const LightGrid& grid, const VolumeOptions& options);

struct LightVolume {
  LightBox box;
  std::vector<float> light;  // kShFloats a texel: radiance as spherical harmonics; x is the fastest index
  size_t lit = 0;            // texels that the grid lights, those near a cell among them
  size_t filled = 0;  // that have the mean of their neighbours, which had light before them; lit + filled: all of them, or 0
};

// Resampled and filled. Where no texel is lit, all are 0.
LightVolume makeLightVolume(const LightGrid& grid, const LightBox& box);

// The largest |coefficient|.
float largestLight(const LightVolume& volume);

}  // namespace nlg
