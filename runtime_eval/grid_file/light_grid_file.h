// Shared parts of the reader and the writer of light grid files, and of the bake's report.
#pragma once

#include "nlg/light_grid.h"

namespace nlg {

// checkLightGrid of a grid whose bricks are still to be made.
FileResult checkWithoutBricks(const LightGrid& grid);

// Where a file's bytes go, without header and fillers.
struct LightGridBytes {
  size_t light = 0;
  size_t theta = 0;
  size_t dictionaries = 0;    // that codes share
  size_t functions = 0;       // which representation each has
  size_t probe_function = 0;  // which function each probe has
  size_t tree = 0;            // where probes stand
  size_t total() const { return light + theta + dictionaries + functions + probe_function + tree; }
};
LightGridBytes lightGridBytes(const LightGrid& grid, const GridPrecision& precision);
// Of packed_light alone: records, axes and what else says how they are read.
size_t packedLightBytes(const LightGrid& grid);

}  // namespace nlg
