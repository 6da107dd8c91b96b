// Furnished interiors from a seed: real furniture of Sweet Home 3D's libraries in procedural houses with thin walls.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace nlg {

// The plans' names: flat, townhouse, office, villa (interiors/plans.h).
const std::vector<std::string>& interiorPlans();

struct Interior {
  Scene scene;                             // id: PLAN_SEED_STEM, STEM the archive's or folder's name in lower case
  std::map<std::string, uint32_t> models;  // "placed": different ones that stand in it; "left out": too fine, or no .obj file
};

// The same bits on every machine for the same arguments and archives. Walls: inner 7–12 cm, outer 15–30 cm, partitions of offices
// 2–4 cm. The shell, stairs and columns of offices are structure; furniture, door leaves, window frames and curtains are movable.
//
// path     a .sh3f file or a folder of them
// throws   UsageError when plan is not one of interiorPlans(); InputError on what FurnitureLibrary refuses
Interior makeInterior(const std::string& path, const std::string& plan, uint64_t seed);

}  // namespace nlg
