// How noisy baked light is, and how fast it is baked: the same probes lit again and again by other seeds.
#pragma once

#include <cstdint>

#include "bake/scene_bake.h"

namespace nlg {

struct NoiseFigures {
  uint64_t probes = 0;        // that some place reads
  double noise_median = 0.0;  // of a probe's coefficients: their standard deviation over their root mean square
  double noise_p95 = 0.0;
  double probes_per_s = 0.0;   // on one core: the median of the runs
  double measure_share = 0.0;  // of that time: rays; the rest finds weights and solves
};

// Lights all probes `runs` times on one thread, each time with rays of another seed at the same places.
// grid   baked, without light; in the world's coordinates
// runs   >= 2
NoiseFigures measureNoise(const BakeScene& scene, const BakeOptions& options, LightGrid grid, int runs);

}  // namespace nlg
