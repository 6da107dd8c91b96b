// A building: an outer shell with storeys, windows and doors as one closed solid, and inner walls that part it into rooms.
#pragma once

#include <vector>

#include "scene/procedural/furniture.h"
#include "scene/procedural/level.h"

namespace nlg {

// A window or door seen from above; a door with the room to walk through it.
struct Opening {
  int storey = 0;
  Rect area;
};

struct Building {
  Rect outer;             // the shell's outside
  double base_m = -0.5;   // how deep its foundation reaches
  double ground_m = 0.0;  // height of the lowest floor
  double wall_m = 0.3, slab_m = 0.2;
  std::vector<double> clear_m;    // clear height of each storey, lowest first
  Rect stairwell;                 // opening in the slabs between storeys; empty when there is one storey
  std::vector<Opening> openings;  // windows and doors so far; neither walls nor furniture stand in them
  BrushGrid shell;

  Rect inner() const { return outer.grown(-wall_m); }
  double floorHeight(int storey) const;
  double roofHeight() const { return floorHeight(static_cast<int>(clear_m.size())); }
  std::vector<Rect> openingsOf(int storey) const;
  int storeyCount() const { return static_cast<int>(clear_m.size()); }
};

// A slab of ground under and around the building, its top at y = -0.02.
void addGround(Level& level, const Building& building, double margin_m);

// The outside and the rooms' air, without openings yet.
void fillShell(Level& level, Building& building);

// Carves a hole through one wall of the shell, given along the wall's inside, y from low to high; margin_m around it stays free.
void carveHole(Building& building, int storey, Side side, double from, double to, double low, double high, double margin_m);

// Carves windows with sills at regular distances into a storey's four walls; some stay closed.
void carveWindows(Level& level, Building& building, int storey, double share);

// Carves a door 2 m high (or as given) at this distance along the wall.
void carveDoor(Building& building, Side side, int storey, double along, double width, double height = 2.05);

// Parts a storey into rooms by inner walls with doors and returns the rooms; walls avoid doors, windows and reserved places.
struct PlanOptions {
  double min_side_m = 2.6;
  double stop_chance = 0.1;  // that a room is left large though it could be parted
  double wall_m = 0.15;
  Mobility mobility = Mobility::movable;
};
std::vector<Room> partStorey(Level& level, const Building& building, int storey, const Rect& area, const PlanOptions& options,
                             std::vector<Rect> keep_free);

// A straight flight of steps along +x of the placement, one closed solid on the ground or, where open, with free space below.
struct Flight {
  double rise_m = 2.8, run_m = 4.0, width_m = 1.0;
  bool is_open = false;
};
void addFlight(Level& level, const Placement& placement, const Flight& flight, uint32_t material);

// Posts and a handrail along +x of the placement.
void addRailing(Level& level, const Placement& placement, double length);

// A balcony's slab, and the railing around its three free edges.
// corner   of its top, at the wall and at the least x; low_m: height of its underside
void addBalcony(Level& level, BrushGrid& shell, const glm::dvec3& corner, double width, double reach, double low_m);

// A gable roof over the rectangle, closed, its ridge along the longer side.
void addGable(Level& level, const Rect& area, double eaves_m, double height_m);

// Rows of columns with base and capital, and the arches or the beam that they carry.
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
