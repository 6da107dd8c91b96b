#include "validate/light/neural/voxel_lattice.h"

#include <algorithm>
#include <cmath>

#include "tool/error.h"

namespace nlg {

VoxelLattice::VoxelLattice(const std::vector<glm::dvec3>& places, double side_m) : low_m(places.front()), voxel_m(side_m) {
  glm::dvec3 high = low_m;
  for (const glm::dvec3& place : places) {
    low_m = glm::min(low_m, place);
    high = glm::max(high, place);
  }
  for (int axis = 0; axis < 3; ++axis) count[axis] = 1 + static_cast<int>((high[axis] - low_m[axis]) / voxel_m);
}

size_t VoxelLattice::at(const glm::dvec3& position_m) const {
  std::array<size_t, 3> i;
  for (int axis = 0; axis < 3; ++axis)
    i[axis] = static_cast<size_t>(std::clamp(std::floor((position_m[axis] - low_m[axis]) / voxel_m), 0.0, count[axis] - 1.0));
  return i[0] + count[0] * (i[1] + count[1] * i[2]);
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

std::vector<VoxelPlaces> placesByVoxel(const VoxelLattice& lattice, const LitPlaces& lit, const PlaceSplit& split) {
  std::vector<PlaceSplit> of_voxel(lattice.size());
  for (const uint32_t place : split.learned) of_voxel[lattice.at(lit.position_m[place])].learned.push_back(place);
  for (const uint32_t place : split.held_out) of_voxel[lattice.at(lit.position_m[place])].held_out.push_back(place);
  std::vector<VoxelPlaces> enough;
  for (size_t voxel = 0; voxel < of_voxel.size(); ++voxel) {
    if (of_voxel[voxel].learned.size() >= kFewestVoxelPlaces) enough.push_back({voxel, std::move(of_voxel[voxel])});
  }
  if (enough.empty()) throw InputError("the scene", "air", "a voxel with enough sample points to learn light from", "none");
  return enough;
}

}  // namespace nlg
