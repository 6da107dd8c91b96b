// Measures the noise of baked light, and its speed: the same probes are lit several times with different seeds.
#pragma once

#include <cstdint>

#include "bake/scene_bake.h"

namespace nlg {

// Of coefficients of light: their standard deviation over their root mean square, of each thing that has any light.
struct Noise {
  uint64_t count = 0;
  double median = 0.0, p95 = 0.0;
};

struct NoiseFigures {
  Noise probes;                // that have a function
  Noise answers;               // of the look-up at the places in air that light was measured at: what is seen of it
  double probes_per_s = 0.0;   // on one core: the median of the runs
  double measure_share = 0.0;  // of that time: rays; the rest finds weights and solves
};

// Lights all probes `runs` times on one thread, each time with rays of another seed at the same places.
// grid   baked, without light; in the world's coordinates
// runs   >= 2
NoiseFigures measureNoise(const PreparedScene& scene, const BakeOptions& options, LightGrid grid, int runs);

}  // namespace nlg
