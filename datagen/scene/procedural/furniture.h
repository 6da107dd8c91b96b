// Furniture and props, each one movable object, and a room's furnishing with them.
#pragma once

#include <vector>

#include "datagen/scene/procedural/level.h"

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

// Single props; the placement is the middle of the foot, local +z the front.
void addTable(Level& level, const Placement& placement, double width, double depth, double height);
void addChair(Level& level, const Placement& placement);
void addShelf(Level& level, const Placement& placement, double width, double depth, double height);
void addCrate(Level& level, const Placement& placement, double side_m);
void addCratePile(Level& level, const Placement& placement, int count);
void addBarrel(Level& level, const Placement& placement, double height);
// A lamp under the ceiling: the placement is the point on the ceiling.
void addCeilingLamp(Level& level, const Placement& placement);
// A pipe from one point, running along the placement's local x, with clamps.
void addPipe(Level& level, const Placement& placement, double length, double radius);

}  // namespace nlg
