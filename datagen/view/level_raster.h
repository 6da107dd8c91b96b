// Draws a level from above, cut open at one height: an orthographic picture with a depth buffer.
#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "datagen/view/function_slice.h"
#include "datagen/view/image.h"

namespace nlg {

// Where the world lies in the picture: x points right, z down.
struct LevelMap {
  glm::dvec2 low_m{0.0};  // world x, z of the upper left corner
  double px_per_m = 1.0;
  int width = 1, height = 1;  // pixels

  glm::dvec2 pixelOf(const glm::dvec3& world_m) const { return (glm::dvec2(world_m.x, world_m.z) - low_m) * px_per_m; }
};

// The map of a box with a margin around it, its longer side of so many pixels.
LevelMap makeLevelMap(const glm::dvec3& low_m, const glm::dvec3& high_m, int side_px);

inline constexpr Colour kMapGround{244, 244, 247};  // nothing below the cut

// The colour of a level surface; share: of the way from the lowest point up to the cut.
Colour heightColour(double share);

// What is seen from above of everything below cut_m: faces that look up, by their height and slope, darker at steps. Hatched
// where the cut lies in solid: the first one-sided face below it shows its back (a level that is only the inside of its rooms),
// or more backs than fronts lie below it (closed solids, which may stand in each other).
//
// triangles   in world coordinates, metres
// floor_m     the height of heightColour(0)
Image drawLevel(const std::vector<ViewTriangle>& triangles, const LevelMap& map, double floor_m, double cut_m);

// The height in the middle half of [low_m, high_m] at which the cut is long and leaves much open: within a tenth of the largest
// product of the cut's length and the area that is not solid, and of these heights the one nearest to the middle. Rooms are cut
// open there, not the slabs between them or the ground.
//
// map   any map of the whole level
double mostTellingHeight(const std::vector<ViewTriangle>& triangles, const LevelMap& map, double low_m, double high_m);

}  // namespace nlg
