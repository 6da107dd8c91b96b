// A solid made of axis-aligned boxes, added and carved in turn, as one watertight surface.
//
// Walls with doors and windows, slabs with stair openings, tables, shelves, flights of stairs: boxes that touch leave no faces
// between them, and every face ends where its neighbours do.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "scene/procedural/mesh_builder.h"

namespace nlg {

// Materials of a box's faces by where they look.
struct BrushMaterials {
  uint32_t side = 0, top = 0, bottom = 0;

  BrushMaterials(uint32_t all) : side(all), top(all), bottom(all) {}  // one material is the common case: implicit
  BrushMaterials(uint32_t side_, uint32_t top_, uint32_t bottom_) : side(side_), top(top_), bottom(bottom_) {}
};

// Coordinates are rounded to 1/256 m; a box thinner than that is nothing.
class BrushGrid {
 public:
  void fill(const glm::dvec3& min, const glm::dvec3& max, const BrushMaterials& materials);
  void carve(const glm::dvec3& min, const glm::dvec3& max);

  // Adds the surface to the builder's current object. Edges at which two boxes touch crosswise belong to four faces.
  void emit(MeshBuilder& mesh, const Placement& placement = {}) const;
  // The same as a new object.
  void emitObject(MeshBuilder& mesh, const std::string& name, Mobility mobility, const Placement& placement = {}) const;

 private:
  struct Operation {
    glm::dvec3 min, max;
    int materials_idx;  // -1 carves
  };
  void add(const glm::dvec3& min, const glm::dvec3& max, int materials_idx);

  std::vector<Operation> operations_;
  std::vector<BrushMaterials> materials_;
};

}  // namespace nlg
