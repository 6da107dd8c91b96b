#include "datagen/probes/probe_grid.h"

#include <cmath>

#include "runtime_eval/support/random.h"
#include "tool/error.h"

namespace nlg {

glm::dvec3 ProbeGrid::probePosition(uint64_t index) const {
  const uint64_t x = index % extent.x, y = index / extent.x % extent.y, z = index / extent.x / extent.y;
  return first_m + static_cast<double>(spacing_m) * glm::dvec3(x, y, z);
}

ProbeGrid makeProbeGrid(const Scene& scene, const ProbeGridOptions& options, uint64_t seed) {
  ProbeGrid grid;
  Random random(mixSeed(seed, 0x67726964));
  const double ratio = options.spacing_max_m / options.spacing_min_m;
  grid.spacing_m = static_cast<float>(options.spacing_min_m * std::pow(ratio, random.uniform()));
  if (scene.triangles.empty()) return grid;
  const Bounds bounds = sceneBounds(scene);
  double probe_count = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double shift = random.uniform() * grid.spacing_m;
    // a scene thinner than a spacing, such as a flat sheet, has its probes on both sides
    const bool thin = bounds.max[axis] - bounds.min[axis] < grid.spacing_m;
    grid.first_m[axis] = bounds.min[axis] + shift - (thin ? grid.spacing_m : 0.0f);
    const double extent = std::max(
        0.0, std::floor((bounds.max[axis] + (thin ? grid.spacing_m : 0.0f) - grid.first_m[axis]) / grid.spacing_m) + 1.0);
    probe_count *= extent;
    if (extent > 1 << 30 || probe_count > static_cast<double>(kMaxProbeCount)) {
      throw UsageError(
          scene.id, "a probe grid of at most 2^40 probes",
          "spacing " + std::to_string(grid.spacing_m) + " m over " + std::to_string(bounds.max[axis] - bounds.min[axis]) + " m");
    }
    grid.extent[axis] = static_cast<int>(extent);
  }
  return grid;
}

ShuffledOrder::ShuffledOrder(uint64_t count, uint64_t seed) : count_(count), mask_(0) {
  while (mask_ + 1 < count) mask_ = 2 * mask_ + 1;
  Random random(mixSeed(seed, 0x6f72646572));
  // full period modulo a power of two: increment odd, multiplier 1 modulo 4 (Hull & Dobell 1962)
  multiplier_ = (uint64_t{random.next()} << 3 | 5) & (mask_ | 7);
  increment_ = (uint64_t{random.next()} << 32 | random.next()) | 1;
  state_ = (uint64_t{random.next()} << 32 | random.next()) & mask_;
}

bool ShuffledOrder::next(uint64_t* index) {
  if (visited_ == count_) return false;
  do state_ = (state_ * multiplier_ + increment_) & mask_;
  while (state_ >= count_);
  ++visited_;
  *index = state_;
  return true;
}

}  // namespace nlg
