// Whether a scene's size is that of a level: what has another was most likely made in another unit.
#pragma once

#include <string>

#include "scene/scene.h"

namespace nlg {

// One sentence, with the unit that may be the file's, about a scene of a size that few levels have: higher than 150 m, longer
// than 5 km or shorter than 50 cm; rooms that are higher than 40 m, as a median over floors, or lower than 25 cm; or, where there
// are no rooms, triangles with edges of 40 m, as a median. Empty for any other scene, and for one without triangles.
//
// path      the scene's file, for errors
// unit_m    metres of one of the file's units, as the scene was read; the sentence's suggestion takes its place
// throws    InputError naming the longest side when it is under 10 cm or over 100 km: no level is of that size
std::string sizeNote(const Scene& scene, const std::string& path, double unit_m);

}  // namespace nlg
