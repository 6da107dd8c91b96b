// Fittings of a house's openings and walls: door leaves, window frames, curtains, pictures.
#pragma once

#include "scene/interiors/home.h"

namespace nlg {

// The point of a wall's face, with local x along the wall and +z into the room.
Placement onWall(const HomeRoom& room, Side side, double along, double y);

// A leaf of 4 cm in a doorway, shut, ajar or open by up to 110 degrees into the room; not through a wall beside it;
// it becomes a solid of the room.
void addLeaf(Home& home, HomeRoom& swings_into, const RoomOpening& opening);
// Frame and bars, without glass: light comes through a window.
void addWindowFrame(Home& home, const HomeRoom& room, const RoomOpening& opening);
// Two pleated sheets before a window, gathered at its sides or drawn; they become solids of the room.
void addCurtains(Home& home, HomeRoom& room, const RoomOpening& window);
// A picture or mirror somewhere on a free place of a wall.
void addPicture(Home& home, HomeRoom& room);

}  // namespace nlg
