// Checks a scene's size for that of a level; another size most likely means another unit.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "scene/model/scene.h"

namespace nlg {

// Where one can stand in a scene, and what is above: evidence of its unit, and of the room that what moves in it needs.
//
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

// One sentence, with the unit that may be the file's, about a scene of a size that few levels have: higher than 150 m, longer
// than 5 km or shorter than 50 cm; rooms that are higher than 40 m, as a median over floors, or lower than 25 cm; or, where there
// are no rooms, triangles with edges of 40 m, as a median. Empty for any other scene, and for one without triangles.
//
// path      the scene's file, for errors
// unit_m    metres of one of the file's units, as the scene was read; the sentence's suggestion takes its place
// throws    InputError naming the longest side when it is under 10 cm or over 100 km: no level is of that size
std::string sizeNote(const Scene& scene, const std::string& path, double unit_m);

// Of a scene with a note, read with a metre a unit: 0.01 or 0.001 where rooms are a storey high by it, 2 to 5 m, and all else is usual.
// No room of a level is 200 m high: the unit is all but certain. 0 for any other scene; of what is too small nothing is certain.
double certainUnit(const Scene& scene);

}  // namespace nlg
