// Sky and sun of a procedural level.
#pragma once

#include <cstdint>

#include "scene/scene_light.h"

namespace nlg {

// Day in two of three levels: a sun 15 to 65 degrees high and a sky; night in the others: a dark sky and no sun. Drawn from a
// stream of its own, so that a level's geometry does not depend on its light. In the unit of the levels' lamps, whose panels have
// radiances of 6 to 14: a window lights a room about as much as a lamp does.
struct Daylight {
  Sky sky;
  std::vector<Sun> suns;
};
Daylight drawDaylight(uint64_t seed);

}  // namespace nlg
