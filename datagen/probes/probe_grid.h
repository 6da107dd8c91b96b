// The uniform grid of probes over a scene.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "datagen/scene/scene.h"

namespace nlg {

struct ProbeGridOptions {
  double spacing_min_m = 0.7;  // distance between probes; each jitter draws its own, uniform in the logarithm
  double spacing_max_m = 2.2;
};

struct ProbeGrid {
  float spacing_m = 1.0f;
  glm::dvec3 first_m{0.0};  // position of probe (0, 0, 0), relative to the scene's origin
  glm::ivec3 extent{0};     // probes along each axis

  uint64_t probeCount() const { return uint64_t(extent.x) * uint64_t(extent.y) * uint64_t(extent.z); }
  glm::dvec3 probePosition(uint64_t index) const;  // x fastest, then y, then z
};

// Largest number of probes of one grid; a scene and spacing that need more are refused.
inline constexpr uint64_t kMaxProbeCount = uint64_t{1} << 40;

// The grid over the scene's bounds, shifted by up to one spacing; spacing and shift are a pure function of (options, seed).
// Along an axis where the scene is thinner than a spacing the grid reaches one spacing beyond it on both sides. An empty scene
// has an empty grid. throws UsageError when the grid would hold more than kMaxProbeCount probes
ProbeGrid makeProbeGrid(const Scene& scene, const ProbeGridOptions& options, uint64_t seed);

// A fixed pseudo-random order of [0, count), visited by repeated calls: a prefix of it is a fair sample of the grid.
// Walks a linear congruence of full period over the next power of two, so that it takes no memory.
class ShuffledOrder {
 public:
  ShuffledOrder(uint64_t count, uint64_t seed);
  bool next(uint64_t* index);  // false when all have been visited

 private:
  uint64_t count_, mask_, multiplier_, increment_, state_, visited_ = 0;
};

}  // namespace nlg
