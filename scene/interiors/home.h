// Shared parts of all floor plans: rooms are carved out of one solid, and the walls are the rest.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "scene/interiors/furniture_library.h"
#include "scene/procedural/building.h"
#include "scene/procedural/level.h"

namespace nlg {

// clang-format off
enum class HomeUse {
  living, dining, kitchen, bedroom, child, bath, toilet, study, hall, store, attic,
  open_office, meeting, lounge, pantry, gallery, salon, terrace
};
// clang-format on

// A box above a footprint.
struct Box {
  Rect area;
  double low = 0.0, high = 0.0;  // metres, of the scene

  bool overlaps(const Box& other) const { return area.overlaps(other.area) && low < other.high && other.low < high; }
};

struct RoomOpening {
  enum class Kind { door, passage, window };
  Kind kind = Kind::door;
  Side side = Side::north;
  double from = 0.0, to = 0.0;  // along the wall, in the scene's x or z
  double low = 0.0, high = 0.0;
};

// A room that is being furnished: its floor, its openings, and what of it is taken.
struct HomeRoom {
  HomeUse use = HomeUse::living;
  Rect floor;  // between the walls' faces
  double floor_m = 0.0, clear_m = 2.5;
  bool has_ceiling = true;       // lamps hang from it
  std::vector<Side> open_sides;  // where there is no wall: nothing hangs there
  std::vector<RoomOpening> openings;
  std::vector<Box> solids;  // what stands in it: nothing else may overlap these
  std::vector<Box> kept;    // what nothing may stand in: before doors, windows and drawers; these may overlap each other

  bool hasWall(Side side) const;
  bool isFree(const Box& box) const;
  // Whether nothing stands in it; what is only kept free does not count.
  bool isEmpty(const Box& box) const;
};

// A piece to stand somewhere: of the library, or, where it has none for a use, one of procedural/furniture.h.
struct Piece {
  FurnitureUse use = FurnitureUse::none;
  glm::dvec3 size_m{0.0};
  double elevation_m = 0.0;
  double top_m = -1.0;                    // as CatalogueEntry's
  const FurnitureModel* model = nullptr;  // null: procedural
  std::string name;
};

struct DoorShape {
  double width_m = 0.85, height_m = 2.03;
  bool has_leaf = true;
  double from = -1e9, to = 1e9;  // the part of the wall that it may stand in, in the scene's x or z
};

struct Home {
  Home(uint64_t seed, FurnitureLibrary& library);

  Level level;
  FurnitureLibrary& library;
  std::vector<Lamp> lamps;
  std::vector<HomeRoom> rooms;
  BrushGrid shell;
  uint32_t curtain_material, glass_material, porcelain_material, paper_material;

  // The shell's outer walls: rooms that come within this of the outside have windows there.
  std::vector<Rect> outsides;
  double outer_wall_m = 0.3, inner_wall_m = 0.1;
  std::map<const FurnitureModel*, uint32_t> first_material;  // of a model that has been placed

  // Carves a room; returns its number.
  size_t addRoom(HomeUse use, const Rect& floor, double floor_m, double clear_m);
  // A doorway in the wall between two rooms that face each other over at most 0.5 m; false when they do not, or other openings
  // leave no place.
  bool connect(size_t a, size_t b, const DoorShape& shape);
  // A doorway to the outside at this distance from the wall's start.
  void doorOutside(size_t room, Side side, double at, const DoorShape& shape, bool is_front_door);
  void window(size_t room, Side side, double from, double to, double low_m, double high_m);
  // Windows at regular distances in those of the room's walls that lie at the outside; share of them that are there.
  void windows(size_t room, double share, double sill_m, double head_m);
  // Whether a room's wall is an outer one.
  bool isOutside(size_t room, Side side) const;
};

// The shell as one object; once all rooms and openings are there.
void finishShell(Home& home);

}  // namespace nlg
