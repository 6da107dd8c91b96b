// The surface on which a field on a grid changes sign, by marching tetrahedra: closed, without cracks or slivers.
#pragma once

#include <cstdint>
#include <vector>

#include "scene/procedural/mesh_builder.h"

namespace nlg {

struct ScalarGrid {
  glm::ivec3 count{0};         // points along x, y, z, two or more each
  double spacing_m = 1.0;      // the placement's position is the first point's
  std::vector<double> values;  // count.x * count.y * count.z, x fastest; > 0 in air

  size_t index(int x, int y, int z) const { return (static_cast<size_t>(z) * count.y + y) * count.x + x; }
};

// Turns every air point that is not connected with the largest body of air into solid.
void keepLargestAir(ScalarGrid& grid);

// Front faces look into the air. Closed when all points of the grid's border are solid: the surface then is a shell around
// the air whose signed volume is negative. Vertices keep a tenth of an edge's length away from grid points.
void addIsosurface(MeshBuilder& mesh, const Placement& placement, const ScalarGrid& grid, uint32_t material);

}  // namespace nlg
