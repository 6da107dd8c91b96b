#include "runtime_eval/light_grid/grid_summary.h"

#include <algorithm>
#include <limits>

namespace nlg {

GridBounds boundsOf(const ProbeTree& tree) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  const ProbeTreeFrame& frame = tree.frame();
  GridBounds bounds{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
  tree.forEachCell([&](const ProbeCell& cell) {
    for (size_t axis = 0; axis < 3; ++axis) {
      const double low_m = frame.first_m[axis] + frame.spacing_m * cell.low[axis];
      bounds.low_m[axis] = std::min(bounds.low_m[axis], low_m);
      bounds.high_m[axis] = std::max(bounds.high_m[axis], low_m + frame.spacing_m * cell.side);
    }
  });
  return bounds;
}

std::array<float, kShChannels> meanRadiance(const LightGrid& grid) {
  std::array<double, kShChannels> sum{};
  size_t count = 0;
  for (size_t probe = 0; probe < grid.probe_function.size() && !grid.light.empty(); ++probe) {
    if (grid.probe_function[probe] == kNoWeight) continue;
    for (size_t c = 0; c < kShChannels; ++c) sum[c] += grid.probeLight(probe)[c];
    ++count;
  }
  std::array<float, kShChannels> mean{};
  // the first basis function is a constant
  for (size_t c = 0; c < kShChannels && count > 0; ++c)
    mean[c] = static_cast<float>(shBasis(0, 0, 0)[0] * sum[c] / static_cast<double>(count));
  return mean;
}

}  // namespace nlg
