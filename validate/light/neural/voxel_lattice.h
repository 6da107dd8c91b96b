// A regular lattice of voxels around sample points, for networks that each cover a part of the scene.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "validate/light/neural/lit_places.h"

namespace nlg {

struct VoxelLattice {
  glm::dvec3 low_m{0.0};  // the lowest voxel's lowest corner
  double voxel_m = 4.0;
  std::array<int, 3> count{};

  VoxelLattice(const std::vector<glm::dvec3>& places, double side_m);
  size_t size() const { return static_cast<size_t>(count[0]) * count[1] * count[2]; }
  // The voxel of a place; beyond the lattice the nearest.
  size_t at(const glm::dvec3& position_m) const;
  glm::dvec3 middleOf(size_t voxel) const;
  SampleFrame frameOf(size_t voxel) const { return {middleOf(voxel), 0.5 * voxel_m}; }
};

// By voxel: the nearest of some.
// some      voxels; not empty
// returns   indices into some
std::vector<uint32_t> nearestOf(const VoxelLattice& lattice, const std::vector<size_t>& some);

// Places to learn from in one voxel, for each that has enough of them.
struct VoxelPlaces {
  size_t voxel;
  PlaceSplit split;
};
inline constexpr size_t kFewestVoxelPlaces = 32;
// throws   InputError where no voxel has as many
std::vector<VoxelPlaces> placesByVoxel(const VoxelLattice& lattice, const LitPlaces& lit, const PlaceSplit& split);

}  // namespace nlg
