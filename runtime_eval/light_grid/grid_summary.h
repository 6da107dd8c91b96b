// What an engine asks of a light grid before it looks up light: where it is, and how bright.
#pragma once

#include <array>

#include "nlg/light_grid.h"

namespace nlg {

struct GridBounds {
  PositionM low_m, high_m;  // low_m > high_m if there are no cells in use
};

// The box of all cells in use, in world coordinates.
GridBounds boundsOf(const ProbeTree& tree);

// Red, green and blue of radiance, as a mean over all directions and all probes that have weight; 0 of a grid without light.
std::array<float, kShChannels> meanRadiance(const LightGrid& grid);

}  // namespace nlg
