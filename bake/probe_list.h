// Prints the probes of a light grid as CSV (`nlg-bake probes`).
#pragma once

#include <string>

#include "nlg/light_grid.h"

namespace nlg {

// CSV with a header, a row a probe in the grid's order: x_m,y_m,z_m, world; kind: function, tent (free space) or none (no weight
// anywhere); and of grids with light r,g,b: its radiance, the mean over all directions. Light is solved for, so that one probe's may
// be below 0.
std::string probeTable(const LightGrid& grid);

// The command `nlg-bake probes`. argv   begins with the command's name. returns   the process's exit code
int probeListMain(int argc, char** argv);

}  // namespace nlg
