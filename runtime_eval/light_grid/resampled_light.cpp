#include "nlg/look_up.h"

#include <algorithm>

namespace nlg {

PositionM LightBox::texelCentre(size_t x, size_t y, size_t z) const {
  const std::array<size_t, 3> texel{x, y, z};
  PositionM centre_m;
  for (size_t axis = 0; axis < 3; ++axis) {
    const double share = (static_cast<double>(texel[axis]) + 0.5) / texel_count[axis];
    centre_m[axis] = low_m[axis] + share * (high_m[axis] - low_m[axis]);
  }
  return centre_m;
}

ResampledLight resampleLight(const LightGrid& grid, const LightBox& box, LookUpScratch* scratch) {
  constexpr size_t kAtOnce = 16384;  // texels: neighbouring rows share cells and functions
  ResampledLight result;
  const size_t count = box.texelCount();
  result.light.resize(count * kShFloats);
  result.status.resize(count);
  std::vector<PositionM> positions_m(std::min(count, kAtOnce));
  for (size_t first = 0; first < count; first += kAtOnce) {
    const size_t piece = std::min(kAtOnce, count - first);
    for (size_t i = first; i < first + piece; ++i) positions_m[i - first] = box.texelCentre(i);
    lookUpLights(grid, positions_m.data(), piece, &result.light[first * kShFloats], &result.status[first], scratch);
  }
  return result;
}

}  // namespace nlg
