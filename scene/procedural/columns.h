// Rows of columns with base and capital, and the arches or the beam that they carry.
#pragma once

#include "scene/procedural/level.h"

namespace nlg {

struct Columns {
  double bay = 3.0, column_m = 3.2, radius = 0.3;  // distance, height and radius
  int side_count = 10;
  bool has_arches = true;

  // from the columns' tops to the underside of what they carry
  double archRise() const { return has_arches ? 0.5 * bay - radius : 0.4; }
};

// One column on the floor at y = 0.
void addColumn(Level& level, const Columns& columns, double x, double z, double height);

// The wall above a row of columns up to top_m, along local x: half-round arches, or a straight beam.
void addArcade(Level& level, const Columns& columns, const Placement& start, int bay_count, double top_m);

// A row of columns with its arcade, along local x; the first and the last column are there where it has ends.
void addColumnRow(Level& level, const Columns& columns, const Placement& start, int bay_count, double top_m, bool has_ends);

}  // namespace nlg
