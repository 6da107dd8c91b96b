// Furnished interiors from a seed: real furniture of Sweet Home 3D's libraries in procedural houses with thin walls.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "scene/interiors/home.h"
#include "scene/model/scene.h"

namespace nlg {

// The plans' names: flat, townhouse, office, villa (plan_*.cpp).
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

// The families of floor plans; each fills a home with rooms, furnished, around the origin.

void buildFlat(Home& home);       // one storey: rooms along a corridor, a living room at its end
void buildTownhouse(Home& home);  // narrow: two storeys and an attic under slopes around an open stairwell
void buildOffice(Home& home);     // one deep storey: desks, columns, meeting rooms behind partitions of 2 to 4 cm
void buildVilla(Home& home);      // a hall with two rows of columns, galleries above its aisles, wings of two storeys, a garden

// A number in [low, high] in steps of 1 cm.
double pickFine(Level& level, double low, double high);
// Parts [from, to] into as many lengths as there are weights, in their proportion, walls of wall_m between; from, to, from, to …
std::vector<double> partLength(Level& level, double from, double to, double wall_m, const std::vector<double>& weights);
// Ground around a house up to y = top_m.
void addGroundPlate(Home& home, const Rect& area, double top_m);

}  // namespace nlg
