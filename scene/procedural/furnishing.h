// A room's furnishing: what stands where.
#pragma once

#include <vector>

#include "scene/procedural/level.h"

namespace nlg {

enum class RoomUse { living, bedroom, study, store, workshop };

// What is being furnished: the free floor, its height, the clear height above, and places that stay free (doors, stairs).
struct Room {
  Rect floor;
  double floor_m = 0.0, clear_m = 2.6;
  std::vector<Rect> keep_free;
};

// Puts furniture along the walls and in the middle, none of it overlapping another or a place to keep free.
// density   0..1: how much of the wall is used
void furnishRoom(Level& level, const Room& room, RoomUse use, double density);

}  // namespace nlg
