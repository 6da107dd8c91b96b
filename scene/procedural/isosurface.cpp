#include "scene/procedural/isosurface.h"

#include <algorithm>
#include <array>

namespace nlg {
namespace {

constexpr uint32_t kNoVertex = ~0u;

// Paths along the cube's edges from corner 0 to corner 7 (bit 0 is x, 1 is y, 2 is z): six tetrahedra that share the diagonal
// and match across the faces of neighbouring cubes.
constexpr std::array<std::array<int, 4>, 6> kTetrahedra = {
    {{0, 1, 3, 7}, {0, 5, 1, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 6, 4, 7}}};

glm::ivec3 cornerOffset(int corner) { return {corner & 1, corner >> 1 & 1, corner >> 2}; }

class Marcher {
 public:
  Marcher(MeshBuilder& mesh, const Placement& placement, const ScalarGrid& grid, uint32_t material)
      : mesh_(mesh), placement_(placement), grid_(grid), material_(material), vertices_(grid.values.size() * 8, kNoVertex) {}

  void marchCube(const glm::ivec3& cube) {
    for (const auto& tetrahedron : kTetrahedra) {
      std::array<int, 4> air{};
      std::array<int, 4> solid{};
      int air_count = 0;
      int solid_count = 0;
      for (int i = 0; i < 4; ++i) (value(cube, tetrahedron[i]) > 0.0 ? air[air_count++] : solid[solid_count++]) = i;
      const auto cut = [&](int a, int b) { return vertex(cube, tetrahedron[a], tetrahedron[b]); };
      if (air_count == 1) emit(cut(air[0], solid[0]), cut(air[0], solid[1]), cut(air[0], solid[2]), isEven(air[0], solid));
      if (air_count == 3) emit(cut(solid[0], air[0]), cut(solid[0], air[1]), cut(solid[0], air[2]), !isEven(solid[0], air));
      if (air_count == 2) {
        const bool even = isEven(air[0], {air[1], solid[0], solid[1], 0});
        const uint32_t a = cut(air[0], solid[0]);
        const uint32_t c = cut(air[1], solid[1]);
        emit(a, cut(air[0], solid[1]), c, even);
        emit(a, c, cut(air[1], solid[0]), even);
      }
    }
  }

 private:
  double value(const glm::ivec3& cube, int corner) const {
    const glm::ivec3 p = cube + cornerOffset(corner);
    return grid_.values[grid_.index(p.x, p.y, p.z)];
  }

  // Whether (first, rest[0], rest[1], rest[2]) is an even permutation of (0, 1, 2, 3).
  static bool isEven(int first, const std::array<int, 4>& rest) {
    const std::array<int, 4> order = {first, rest[0], rest[1], rest[2]};
    int inversions = 0;
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) inversions += order[i] > order[j];
    }
    return inversions % 2 == 0;
  }

  // A triangle that looks away from the air when its corners stand in the even order: turned so that it looks into it.
  void emit(uint32_t a, uint32_t b, uint32_t c, bool is_even) {
    mesh_.addTriangle(a, is_even ? c : b, is_even ? b : c, material_);
  }

  // The vertex on the edge between two corners; its lower corner and its direction name it.
  uint32_t vertex(const glm::ivec3& cube, int from, int to) {
    if (from > to) std::swap(from, to);
    const glm::ivec3 low = cube + cornerOffset(from);
    uint32_t& entry = vertices_[grid_.index(low.x, low.y, low.z) * 8 + static_cast<size_t>(from ^ to)];
    if (entry == kNoVertex) {
      const double a = value(cube, from);
      const double b = value(cube, to);
      const double t = std::clamp(a / (a - b), 0.1, 0.9);
      const glm::dvec3 start(low);
      const glm::dvec3 end(cube + cornerOffset(to));
      entry = mesh_.addVertex(placement_, (start + (end - start) * t) * grid_.spacing_m);
    }
    return entry;
  }

  MeshBuilder& mesh_;
  const Placement& placement_;
  const ScalarGrid& grid_;
  uint32_t material_;
  std::vector<uint32_t> vertices_;
};

// Labels the air that hangs together with a point; edges of the tetrahedra are what connects.
size_t floodAir(const ScalarGrid& grid, const glm::ivec3& start, int label, std::vector<int>& labels) {
  std::vector<glm::ivec3> open = {start};
  labels[grid.index(start.x, start.y, start.z)] = label;
  size_t count = 0;
  while (!open.empty()) {
    const glm::ivec3 p = open.back();
    open.pop_back();
    ++count;
    for (int step = 1; step < 15; ++step) {
      const glm::ivec3 q = step < 8 ? p + cornerOffset(step) : p - cornerOffset(step - 7);
      if (q.x < 0 || q.y < 0 || q.z < 0 || q.x >= grid.count.x || q.y >= grid.count.y || q.z >= grid.count.z) continue;
      const size_t idx = grid.index(q.x, q.y, q.z);
      if (grid.values[idx] <= 0.0 || labels[idx] != 0) continue;
      labels[idx] = label;
      open.push_back(q);
    }
  }
  return count;
}

}  // namespace

void keepLargestAir(ScalarGrid& grid) {
  std::vector<int> labels(grid.values.size(), 0);
  int last_label = 0;
  int largest_label = 0;
  size_t largest_count = 0;
  for (int z = 0; z < grid.count.z; ++z) {
    for (int y = 0; y < grid.count.y; ++y) {
      for (int x = 0; x < grid.count.x; ++x) {
        const size_t idx = grid.index(x, y, z);
        if (grid.values[idx] <= 0.0 || labels[idx] != 0) continue;
        const size_t count = floodAir(grid, {x, y, z}, ++last_label, labels);
        if (count > largest_count) {
          largest_count = count;
          largest_label = last_label;
        }
      }
    }
  }
  for (size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] != largest_label && grid.values[i] > 0.0) grid.values[i] = -grid.values[i];
  }
}

void addIsosurface(MeshBuilder& mesh, const Placement& placement, const ScalarGrid& grid, uint32_t material) {
  Marcher marcher(mesh, placement, grid, material);
  for (int z = 0; z + 1 < grid.count.z; ++z) {
    for (int y = 0; y + 1 < grid.count.y; ++y) {
      for (int x = 0; x + 1 < grid.count.x; ++x) marcher.marchCube({x, y, z});
    }
  }
}

}  // namespace nlg
