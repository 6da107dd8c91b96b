// The families of floor plans; each fills a home with rooms, furnished, around the origin.
#pragma once

#include "scene/interiors/home.h"

namespace nlg {

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
