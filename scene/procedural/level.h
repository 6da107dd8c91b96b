// What all families of procedural levels share: the builder, a palette drawn from the seed, and the seed's stream.
#pragma once

#include <string>
#include <vector>

#include "runtime_eval/numbers/random.h"
#include "scene/brush_grid.h"
#include "scene/mesh_builder.h"

namespace nlg {

// Materials by use; the colours vary with the seed, darker and lighter within what such surfaces have.
struct Palette {
  uint32_t wall, inner_wall, floor, ceiling, roof, stone, wood, dark_wood, metal, cloth, ground, rock, leaf, lamp;
};

struct Rect {
  double x0 = 0.0, z0 = 0.0, x1 = 0.0, z1 = 0.0;

  double width() const { return x1 - x0; }
  double depth() const { return z1 - z0; }
  glm::dvec2 middle() const { return {0.5 * (x0 + x1), 0.5 * (z0 + z1)}; }
  Rect grown(double margin) const { return {x0 - margin, z0 - margin, x1 + margin, z1 + margin}; }
  bool overlaps(const Rect& other) const { return x0 < other.x1 && other.x0 < x1 && z0 < other.z1 && other.z0 < z1; }
};

// Draws from the stream stand one to a statement, or in braces: the order of a call's arguments is the compiler's choice.
struct Level {
  explicit Level(uint64_t seed);

  MeshBuilder mesh;
  Random random;
  Palette palette;

  // Faces of rooms: walls, floor on top, ceiling below.
  BrushMaterials roomFaces() const { return {palette.wall, palette.floor, palette.ceiling}; }
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

}  // namespace nlg
