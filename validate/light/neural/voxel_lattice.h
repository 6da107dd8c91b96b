// A regular lattice of voxels around sample points, for networks that each answer for a part of the scene.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace nlg {

struct VoxelLattice {
  glm::dvec3 low_m{0.0};  // the lowest voxel's lowest corner
  double voxel_m = 4.0;
  std::array<int, 3> count{};

  VoxelLattice(const std::vector<glm::dvec3>& places, double side_m);
  size_t size() const { return static_cast<size_t>(count[0]) * count[1] * count[2]; }
  glm::dvec3 middleOf(size_t voxel) const;
};

// By voxel: the nearest of some.
// some      voxels; not empty
// returns   indices into some
std::vector<uint32_t> nearestOf(const VoxelLattice& lattice, const std::vector<size_t>& some);

}  // namespace nlg
