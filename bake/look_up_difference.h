// How far two light grids of one scene are apart: the weights that look-ups give.
#pragma once

#include <cstdint>

#include "runtime_eval/light_grid/light_grid.h"

namespace nlg {

struct LookUpDifference {
  uint64_t look_ups = 0, changed = 0;  // at how many positions; at how many of them some weight has other bits
  double largest = 0.0;                // |difference of a probe's weight|; one that a look-up leaves out counts as 0
  double mean = 0.0;                   // over the positions, of the largest at each

  bool none() const { return changed == 0; }
};

// Looks up at random positions: a cell of the tree at random, a place in it at random, so that most lie where probes are dense.
// The same seed gives the same positions.
//
// a, b   grids that checkLightGrid accepts, of the same tree
LookUpDifference lookUpDifference(const LightGrid& a, const LightGrid& b, uint64_t look_ups, uint64_t seed);

}  // namespace nlg
