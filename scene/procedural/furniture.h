// Furniture and props, each one movable object.
#pragma once

#include <vector>

#include "scene/procedural/level.h"

namespace nlg {

// The placement is the middle of the foot, local +z the front. size_m: along x, y and z; beds and sofas have their own heights.
void addTable(Level& level, const Placement& placement, const glm::dvec3& size_m);
void addBed(Level& level, const Placement& placement, const glm::dvec3& size_m);
void addSofa(Level& level, const Placement& placement, const glm::dvec3& size_m);
void addCupboard(Level& level, const Placement& placement, const glm::dvec3& size_m);
void addMachine(Level& level, const Placement& placement, const glm::dvec3& size_m);
// A table with chairs around it, all facing it.
void addDiningGroup(Level& level, const Placement& placement, double width, double depth);
void addChair(Level& level, const Placement& placement);
void addShelf(Level& level, const Placement& placement, const glm::dvec3& size_m);
void addCrate(Level& level, const Placement& placement, double side_m);
void addCratePile(Level& level, const Placement& placement, int count);
void addBarrel(Level& level, const Placement& placement, double height);
// A lamp under the ceiling: the placement is the point on the ceiling.
void addCeilingLamp(Level& level, const Placement& placement);
// A pipe from one point, running along the placement's local x, with clamps.
void addPipe(Level& level, const Placement& placement, double length, double radius);
// A tree of 3 to 6 m: trunk and crown.
void addTree(Level& level, const glm::dvec3& foot);

// A room's furnishing: what stands where.
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
