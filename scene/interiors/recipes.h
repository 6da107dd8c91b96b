// Furniture of each kind of room.
#pragma once

#include "scene/interiors/home.h"

namespace nlg {

// Furnishes one room by its use.
void furnish(Home& home, HomeRoom& room);

// A table with chairs all around, somewhere in the room, with a lamp above; false when there is no place.
bool addTableGroup(Home& home, HomeRoom& room, double most_length_m);
// Two rows of desks back to back with a low partition of 2 to 4 cm between, chairs and computers; per_row desks in each.
// It stands within 2 m of the wanted middle, where it is free; or not at all.
void addDeskIsland(Home& home, HomeRoom& room, const glm::dvec2& wanted, bool along_x, int per_row);
// People and animals that stand about.
void addPeople(Home& home, HomeRoom& room, int count);

}  // namespace nlg
