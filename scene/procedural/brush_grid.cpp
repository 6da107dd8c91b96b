#include "scene/procedural/brush_grid.h"

#include <algorithm>
#include <array>

namespace nlg {
namespace {

constexpr uint32_t kNoVertex = ~0u;

constexpr double kPlanesPerMetre = 256.0;

// The cells between all planes of all boxes: what is solid, and which vertex stands at which corner.
struct Cells {
  std::array<std::vector<double>, 3> planes;
  std::vector<int> materials_idx;  // one a cell, -1 for air
  std::vector<uint32_t> vertices;  // one a corner of the grid, made when first asked for

  int count(int axis) const { return static_cast<int>(planes[axis].size()) - 1; }
  size_t cell(const glm::ivec3& c) const { return (static_cast<size_t>(c.z) * count(1) + c.y) * count(0) + c.x; }
  size_t corner(const glm::ivec3& c) const { return (static_cast<size_t>(c.z) * (count(1) + 1) + c.y) * (count(0) + 1) + c.x; }
  bool isInside(const glm::ivec3& c) const {
    return c.x >= 0 && c.y >= 0 && c.z >= 0 && c.x < count(0) && c.y < count(1) && c.z < count(2);
  }
  int materialsAt(const glm::ivec3& c) const { return isInside(c) ? materials_idx[cell(c)] : -1; }
  int planeIndex(int axis, double at) const {
    return static_cast<int>(std::lower_bound(planes[axis].begin(), planes[axis].end(), at) - planes[axis].begin());
  }
};

void paint(Cells& cells, const glm::dvec3& min, const glm::dvec3& max, int materials_idx) {
  glm::ivec3 from;
  glm::ivec3 to;
  for (int axis = 0; axis < 3; ++axis) {
    from[axis] = cells.planeIndex(axis, min[axis]);
    to[axis] = cells.planeIndex(axis, max[axis]);
  }
  for (int z = from.z; z < to.z; ++z) {
    for (int y = from.y; y < to.y; ++y) {
      for (int x = from.x; x < to.x; ++x) cells.materials_idx[cells.cell({x, y, z})] = materials_idx;
    }
  }
}

// Emits the cell's face towards +axis or -axis.
void emitFace(Cells& cells, const glm::ivec3& c, int axis, int side, uint32_t material, MeshBuilder& mesh,
              const Placement& placement) {
  const int u = (axis + 1) % 3;
  const int v = (axis + 2) % 3;
  std::array<uint32_t, 4> quad{};
  for (int i = 0; i < 4; ++i) {
    glm::ivec3 corner = c;
    corner[axis] += side;
    corner[u] += i == 1 || i == 2;
    corner[v] += i >= 2;
    uint32_t& vertex = cells.vertices[cells.corner(corner)];
    if (vertex == kNoVertex) {
      vertex = mesh.addVertex(placement, {cells.planes[0][corner.x], cells.planes[1][corner.y], cells.planes[2][corner.z]});
    }
    quad[i] = vertex;
  }
  if (side == 0) std::swap(quad[1], quad[3]);
  mesh.addQuad(quad[0], quad[1], quad[2], quad[3], material);
}

}  // namespace

void BrushGrid::add(const glm::dvec3& min, const glm::dvec3& max, int materials_idx) {
  Operation operation{{}, {}, materials_idx};
  for (int axis = 0; axis < 3; ++axis) {
    operation.min[axis] = snapped(min[axis], kPlanesPerMetre);
    operation.max[axis] = snapped(max[axis], kPlanesPerMetre);
    if (operation.min[axis] >= operation.max[axis]) return;
  }
  operations_.push_back(operation);
}

void BrushGrid::fill(const glm::dvec3& min, const glm::dvec3& max, const BrushMaterials& materials) {
  materials_.push_back(materials);
  add(min, max, static_cast<int>(materials_.size()) - 1);
}

void BrushGrid::carve(const glm::dvec3& min, const glm::dvec3& max) { add(min, max, -1); }

void BrushGrid::emitObject(MeshBuilder& mesh, const std::string& name, Mobility mobility, const Placement& placement) const {
  mesh.beginObject(name, mobility);
  emit(mesh, placement);
}

void BrushGrid::emit(MeshBuilder& mesh, const Placement& placement) const {
  if (operations_.empty()) return;
  // the planes of all boxes cut space into cells, each wholly solid or air: no booleans of meshes
  Cells cells;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double>& planes = cells.planes[axis];
    for (const Operation& operation : operations_) planes.insert(planes.end(), {operation.min[axis], operation.max[axis]});
    std::sort(planes.begin(), planes.end());
    planes.erase(std::unique(planes.begin(), planes.end()), planes.end());
  }
  cells.materials_idx.assign(static_cast<size_t>(cells.count(0)) * cells.count(1) * cells.count(2), -1);
  cells.vertices.assign(cells.corner({cells.count(0), cells.count(1), cells.count(2)}) + 1, kNoVertex);
  // in the order of operations: a later one overwrites an earlier one
  for (const Operation& operation : operations_) paint(cells, operation.min, operation.max, operation.materials_idx);

  // faces between solid and air alone: nothing within walls, and shared corners without cracks
  for (int z = 0; z < cells.count(2); ++z) {
    for (int y = 0; y < cells.count(1); ++y) {
      for (int x = 0; x < cells.count(0); ++x) {
        const int materials_idx = cells.materialsAt({x, y, z});
        if (materials_idx < 0) continue;
        const BrushMaterials& materials = materials_[materials_idx];
        for (int face = 0; face < 6; ++face) {
          const int axis = face / 2;
          const int side = face % 2;
          glm::ivec3 neighbour(x, y, z);
          neighbour[axis] += side == 0 ? -1 : 1;
          if (cells.materialsAt(neighbour) >= 0) continue;
          const uint32_t material = axis != 1 ? materials.side : side == 0 ? materials.bottom : materials.top;
          emitFace(cells, {x, y, z}, axis, side, material, mesh, placement);
        }
      }
    }
  }
}

}  // namespace nlg
