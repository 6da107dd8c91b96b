// Finds the faces of double-sided materials that bound solid, because exporters write doubleSided where nobody chose it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scene/model/scene.h"

namespace nlg {

struct DoubleSidedFaces {
  uint32_t face_count = 0;          // of double-sided materials, transmissive surfaces aside
  uint32_t solid_count = 0;         // of these, made one-sided
  std::vector<std::string> hollow;  // objects with shells wound outward that are no solids, each once
  std::vector<std::string> turned;  // the same whose faces look inward now: rooms with all else in them
  bool is_too_tangled = false;      // more closed parts lie over each other than are looked into: all stay sheets

  // One sentence for the scene's user; empty where no face is of a double-sided material.
  std::string note() const;
};

// Gives faces of double-sided materials that bound solid a one-sided copy of their material, appended to the scene's: those of
// shells, closed or nearly, by the rule of docs/theory/visibility.md, "Double-sided materials", for which the scene's cavity_m must
// be known. Transmissive surfaces stay what they are, and close nothing. A scene without double-sided materials stays as it is.
DoubleSidedFaces giveSolidsOneSide(Scene& scene);

}  // namespace nlg
