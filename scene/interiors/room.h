// A room that is being furnished: its floor, its openings, and what of it is taken.
#pragma once

#include <vector>

#include "scene/procedural/building.h"
#include "scene/procedural/level.h"

namespace nlg {

enum class HomeUse {
  living,
  dining,
  kitchen,
  bedroom,
  child,
  bath,
  toilet,
  study,
  hall,
  store,
  attic,
  open_office,
  meeting,
  lounge,
  pantry,
  gallery,
  salon,
  terrace
};

// A box above a footprint.
struct Box {
  Rect area;
  double low = 0.0, high = 0.0;  // metres, of the scene

  bool overlaps(const Box& other) const { return area.overlaps(other.area) && low < other.high && other.low < high; }
};

struct RoomOpening {
  enum class Kind { door, passage, window };
  Kind kind = Kind::door;
  Side side = Side::north;
  double from = 0.0, to = 0.0;  // along the wall, in the scene's x or z
  double low = 0.0, high = 0.0;
};

struct HomeRoom {
  HomeUse use = HomeUse::living;
  Rect floor;  // between the walls' faces
  double floor_m = 0.0, clear_m = 2.5;
  bool has_ceiling = true;       // lamps hang from it
  std::vector<Side> open_sides;  // where there is no wall: nothing hangs there
  std::vector<RoomOpening> openings;
  std::vector<Box> solids;  // what stands in it: nothing else may overlap these
  std::vector<Box> kept;    // what nothing may stand in: before doors, windows and drawers; these may overlap each other

  bool hasWall(Side side) const;
  bool isFree(const Box& box) const;
  // Whether nothing stands in it; what is only kept free does not count.
  bool isEmpty(const Box& box) const;
};

}  // namespace nlg
