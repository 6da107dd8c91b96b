#include "validate/light/neural/voxel_lattice.h"

#include <algorithm>

namespace nlg {

VoxelLattice::VoxelLattice(const std::vector<glm::dvec3>& places, double side_m) : low_m(places.front()), voxel_m(side_m) {
  glm::dvec3 high = low_m;
  for (const glm::dvec3& place : places) {
    low_m = glm::min(low_m, place);
    high = glm::max(high, place);
  }
  for (int axis = 0; axis < 3; ++axis) count[axis] = 1 + static_cast<int>((high[axis] - low_m[axis]) / voxel_m);
}

glm::dvec3 VoxelLattice::middleOf(size_t voxel) const {
  const size_t x = voxel % count[0], y = voxel / count[0] % count[1], z = voxel / count[0] / count[1];
  return low_m + voxel_m * (glm::dvec3(x, y, z) + 0.5);
}

std::vector<uint32_t> nearestOf(const VoxelLattice& lattice, const std::vector<size_t>& some) {
  std::vector<uint32_t> nearest(lattice.size(), 0);
  for (size_t voxel = 0; voxel < nearest.size(); ++voxel) {
    const auto distance = [&](size_t other) {
      const glm::dvec3 way = lattice.middleOf(other) - lattice.middleOf(voxel);
      return glm::dot(way, way);
    };
    const auto found = std::min_element(some.begin(), some.end(), [&](size_t a, size_t b) { return distance(a) < distance(b); });
    nearest[voxel] = static_cast<uint32_t>(found - some.begin());
  }
  return nearest;
}

}  // namespace nlg
