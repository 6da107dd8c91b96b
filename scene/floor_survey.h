// Where one can stand in a scene, and what is above: evidence of its unit, and of the room that what moves in it needs.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "scene/scene.h"

namespace nlg {

// A place on a surface that faces up, within 45 degrees.
struct Floor {
  static constexpr float kNone = std::numeric_limits<float>::infinity();
  glm::vec3 position{0.0f};  // relative to the scene's origin
  float ceiling_m = kNone;   // up to the next surface or face of the sky above; kNone: open
  float depth_m = 0.0f;      // down to the lowest surface below; 0: none
};

// Some hundred such places, evenly by area; none where nothing faces up. Takes a fraction of a second for millions of triangles. The
// same on every machine.
std::vector<Floor> surveyFloors(const Scene& scene);

// The median ceiling, where at least a quarter of the floors has one.
std::optional<float> medianCeiling(const std::vector<Floor>& floors);

// What a grid over a scene's bounds should hold besides them, world coordinates: lamps; a figure of 2.5 m on floors under the open
// sky that are ground, or that stand no more than 1.5 m above the lowest surface; and margin_m of air over other floors under the
// open sky, as roofs. Lamps further away than the scene is long stand for the sun. None where the bounds hold all of it.
std::optional<ExtentBox> reachBeyondBounds(const Scene& scene, double margin_m);

}  // namespace nlg
