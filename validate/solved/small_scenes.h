// Small rooms of axis-aligned boxes, in which weighting functions can be solved for: each holds one thing that functions must
// cope with. Probes stand a metre apart.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"

namespace nlg {

// Probes at first_m + spacing * (i, j, k).
struct ProbeLattice {
  glm::vec3 first_m{0.0f};
  glm::ivec3 extent{0};
  float spacing_m = 1.0f;

  glm::vec3 position(const glm::ivec3& at) const { return first_m + spacing_m * glm::vec3(at); }
  int index(const glm::ivec3& at) const { return at.x + extent.x * (at.y + extent.y * at.z); }
  int count() const { return extent.x * extent.y * extent.z; }
};

struct SmallScene {
  std::string name;
  std::vector<Bounds> solids;  // closed boxes; all that is not in one, and inside the room, is air
  Bounds room;
  ProbeLattice lattice;  // covers the room; some of its probes stand in solids
  int slice_axis = 1;    // pictures show the plane where this coordinate is slice_m
  float slice_m = 0.0f;

  bool inAir(const glm::vec3& at) const;
  Scene makeScene() const;  // the solids as triangles, faces outward
};

// two_rooms, doorway, column, clutter, corridor, table.
std::vector<std::string> smallSceneNames();

// throws UsageError for a name that is not one of smallSceneNames()
SmallScene makeSmallScene(const std::string& name);

}  // namespace nlg
