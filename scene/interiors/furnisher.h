// Places furniture in rooms: against walls, in the middle, on top of each other; never overlapping or before a door.
#pragma once

#include <optional>
#include <vector>

#include "scene/interiors/home.h"

namespace nlg {

struct MostSize {
  double width_m = 4.0, depth_m = 4.0, height_m = 4.0;
};

// A piece of a use, drawn among the library's that are no larger; where it has none, a procedural one, if there is such.
std::optional<Piece> drawPiece(Home& home, FurnitureUse use, const MostSize& most = {});

// A piece that stands somewhere.
struct Stood {
  Piece piece;
  Placement placement;  // the middle of its foot
  Rect area;
  double degrees = 0.0;
  Side wall = Side::north;  // behind it, when it stands at one
};

// Adds the piece's triangles, and what of it shines.
void emitPiece(Home& home, const Piece& piece, const Placement& placement);

struct WallWish {
  std::optional<Side> side;  // nothing: any
  std::optional<double> at;  // where its middle should be along the wall; nothing: anywhere, corners somewhat preferred
  double access_m = 0.5;     // what stays free before it
  double gap_m = 0.02;       // to the wall: skirting, and no faces in one plane
};
std::optional<Stood> standAtWall(Home& home, HomeRoom& room, const Piece& piece, const WallWish& wish = {});

// Draws a piece and stands it there; nothing where there is none, or no place.
std::optional<Stood> addAtWall(Home& home, HomeRoom& room, FurnitureUse use, const WallWish& wish = {});
std::optional<Stood> addAtWall(Home& home, HomeRoom& room, FurnitureUse use, const MostSize& most, const WallWish& wish);
std::optional<Stood> addAnywhere(Home& home, HomeRoom& room, FurnitureUse use, const MostSize& most, double margin_m);

// The footprint's bounds after a turn by any angle.
Rect footprint(const Piece& piece, const glm::dvec2& middle, double degrees);
// In the open; margin_m: what stays empty around it.
std::optional<Stood> standFree(Home& home, HomeRoom& room, const Piece& piece, const glm::dvec2& middle, double degrees,
                               double margin_m = 0.0);
// Anywhere in the room that is free.
std::optional<Stood> standAnywhere(Home& home, HomeRoom& room, const Piece& piece, double margin_m);
// Small things on a piece's top, at most count; none where no piece stands.
void putOnTop(Home& home, const std::optional<Stood>& below, const std::vector<FurnitureUse>& uses, int count);
// A lamp under the ceiling.
void hangLamp(Home& home, HomeRoom& room, const glm::dvec2& middle);

// Furnishes a room by its use (recipes.cpp).
void furnish(Home& home, HomeRoom& room);

}  // namespace nlg
