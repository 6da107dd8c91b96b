// Finds the parts of a level that can be moved without opening its shell.
#pragma once

#include "scene/scene.h"

namespace nlg {

// Splits an object into its connected components and leaves movable only those that stand free: what looks outward round more
// than half of its box (a crate without the bottom that stands on the floor, a column between floor and ceiling), or all round
// whatever its shape is, and is not larger than 12 m. Walls, rooms, trims and terrain become structure. The other objects stay as
// they are, behind it.
//
// object_idx   below scene.objects.size()
void splitFreeStanding(Scene& scene, size_t object_idx);

}  // namespace nlg
