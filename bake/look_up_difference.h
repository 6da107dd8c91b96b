// How far two light grids of one scene are apart: the weights that look-ups give.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "runtime_eval/light_grid/light_grid.h"

namespace nlg {

// Where two grids are compared: random places, a cell of the tree at random, a place in it at random, so that most lie where probes
// are dense; of these those in air. In solid no function is fitted to anything, and weights there say nothing.
// The same seed gives the same places.
//
// draws    how many are drawn; what is returned are those of them that is_air is true of, in the tree's coordinates
std::vector<PositionM> lookUpPlaces(const ProbeTree& tree, uint64_t draws, uint64_t seed,
                                    const std::function<bool(const PositionM&)>& is_air);

struct LookUpDifference {
  uint64_t look_ups = 0, changed = 0;  // at how many places; at how many of them some weight has other bits
  double largest = 0.0;                // |difference of a probe's weight|; one that a look-up leaves out counts as 0
  double mean = 0.0;                   // over the places, of the largest at each
};

// a, b   grids that checkLightGrid accepts, of the same tree
LookUpDifference lookUpDifference(const LightGrid& a, const LightGrid& b, const std::vector<PositionM>& places);

}  // namespace nlg
