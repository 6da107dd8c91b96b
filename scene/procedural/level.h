// Shared parts of all families of procedural levels: builder, palette and random stream from the seed.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "runtime_eval/numbers/random.h"
#include "scene/model/scene_light.h"
#include "scene/procedural/brush_grid.h"
#include "scene/procedural/mesh_builder.h"

namespace nlg {

// The names of a table's entries.
template <class Table>
std::vector<std::string> namesOf(const Table& table) {
  std::vector<std::string> names;
  for (const auto& entry : table) names.emplace_back(entry.name);
  return names;
}

// Materials by use; the colours vary with the seed, darker and lighter within what such surfaces have.
struct Palette {
  uint32_t wall, inner_wall, floor, ceiling, roof, stone, wood, dark_wood, metal, cloth, ground, rock, leaf, lamp;
};

enum class Side { north, west, south, east };  // -z, -x, +z, +x
inline constexpr Side kSides[] = {Side::north, Side::west, Side::south, Side::east};
// Whether a wall at that side runs along x.
inline bool alongX(Side side) { return side == Side::north || side == Side::south; }
inline Side opposite(Side side) { return static_cast<Side>((static_cast<int>(side) + 2) % 4); }
// Degrees that turn a piece whose front looks towards +z so that its back is at that wall.
inline double degreesAt(Side wall) { return 90.0 * static_cast<int>(wall); }

struct Rect {
  double x0 = 0.0, z0 = 0.0, x1 = 0.0, z1 = 0.0;

  double width() const { return x1 - x0; }
  double depth() const { return z1 - z0; }
  glm::dvec2 middle() const { return {0.5 * (x0 + x1), 0.5 * (z0 + z1)}; }
  Rect grown(double margin) const { return {x0 - margin, z0 - margin, x1 + margin, z1 + margin}; }
  double edge(Side side) const { return side == Side::north ? z0 : side == Side::west ? x0 : side == Side::south ? z1 : x1; }
  // A side's length, and where it starts along x or z.
  double length(Side side) const { return alongX(side) ? width() : depth(); }
  double start(Side side) const { return alongX(side) ? x0 : z0; }
  // Along a side, from its inside's `gap` to `depth`.
  Rect strip(Side side, double from, double to, double depth, double gap = 0.0) const {
    const bool is_low = side == Side::north || side == Side::west;
    return across(side, from, to, edge(side) + (is_low ? gap : -gap), edge(side) + (is_low ? depth : -depth));
  }
  // The part between two planes that lie as a wall at that side does.
  Rect between(Side side, double low, double high) const {
    return alongX(side) ? Rect{x0, low, x1, high} : Rect{low, z0, high, z1};
  }
  // From one such plane to another, in whatever order.
  static Rect across(Side side, double from, double to, double plane, double other) {
    const double near = std::min(plane, other), far = std::max(plane, other);
    return alongX(side) ? Rect{from, near, to, far} : Rect{near, from, far, to};
  }
  bool overlaps(const Rect& other) const { return x0 < other.x1 && other.x0 < x1 && z0 < other.z1 && other.z0 < z1; }
};

// A camera in world coordinates, metres.
struct View {
  std::string name;
  glm::dvec3 eye, look;
};
inline constexpr double kViewDegrees = 65.0;  // from a picture's lower to its upper edge

// Draws from the stream stand one to a statement, or in braces: the order of a call's arguments is the compiler's choice.
struct Level {
  explicit Level(uint64_t seed);

  MeshBuilder mesh;
  Random random;
  Palette palette;
  std::vector<View> views;  // of families that have some

  // Faces of rooms: walls, floor on top, ceiling below.
  BrushMaterials roomFaces() const { return {palette.wall, palette.floor, palette.ceiling}; }
  BrushMaterials roofFaces() const { return {palette.wall, palette.roof, palette.ceiling}; }
  // A number in [low, high], in steps of 5 cm so that edges that ought to line up do.
  double pick(double low, double high);
  int pickCount(int low, int high) { return low + static_cast<int>(random.below(static_cast<uint32_t>(high - low + 1))); }
};

// One function a family; each fills the level with objects around the origin, ground at y = 0.
void buildHouse(Level& level);
void buildMaze(Level& level);
void buildColonnade(Level& level);
void buildStairs(Level& level);
void buildClutter(Level& level);
void buildOutdoor(Level& level);
void buildCave(Level& level);
void buildApartment(Level& level);
void buildKitchen(Level& level);
void buildGallery(Level& level);
void buildMeeting(Level& level);

// Sky and sun of a procedural level.
//
// Day in two of three levels: a sun 15 to 65 degrees high and a sky; night in the others: a dark sky and no sun. Drawn from a
// stream of its own, so that a level's geometry does not depend on its light. In the unit of the levels' lamps, whose panels have
// radiances of 6 to 14: a window lights a room about as much as a lamp does.
struct Daylight {
  Sky sky;
  std::vector<Sun> suns;
};
Daylight drawDaylight(uint64_t seed);

}  // namespace nlg
