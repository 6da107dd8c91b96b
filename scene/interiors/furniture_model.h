// A model of furniture, ready to stand in a room: in metres, upright, of its catalogue's size, and not finer than it need be.
#pragma once

#include <cstdint>
#include <vector>

#include "scene/interiors/catalogue.h"
#include "scene/scene.h"

namespace nlg {

// The middle of the foot is the origin, y up, the front towards +z. Positions are multiples of 1/1024 m.
//
// Its materials are plain: a mean over the material's area stands in the place of an image, and what lets light through is whole. So
// coarsening loses no colour.
//
// Which faces are evidence of solid is decided by connected component: one that is closed (each edge runs as often one way as the
// other) and whose signed volume is above zero is wound outwards and one-sided; all others are open sheets or inside out, and get
// a double-sided copy of their material. It is decided last, of what stands in the room: a surface that lost faces to coarsening is
// open.
struct FurnitureModel {
  std::vector<glm::dvec3> positions;
  std::vector<glm::uvec3> triangles;
  std::vector<uint32_t> triangle_material;
  std::vector<Material> materials;
};

// Models above the budget are coarsened. Vertices in one cell of a cubic lattice become one at their mean. Triangles that lose their
// area go, and so do those that stand on another in the same sense. Cells grow from 4 mm to a twentieth of the longest side until
// the budget is met.
inline constexpr uint32_t kModelTriangleBudget = 5000;

// model     as obj_reader reads it, in whatever unit
// returns   the model; without triangles when none is left, or when even the coarsest lattice does not meet the budget
FurnitureModel fitFurnitureModel(const Scene& model, const CatalogueEntry& entry);

}  // namespace nlg
