// Delaunay tetrahedra of points in space, by Qhull. Only this code uses Qhull.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace nlg {

inline constexpr uint32_t kNoTetrahedron = 0xffffffffu;

struct Tetrahedron {
  std::array<uint32_t, 4> vertex{};     // index into the points
  std::array<uint32_t, 4> neighbour{};  // the one that shares the other three vertices; kNoTetrahedron at the hull
};

// Barber, Dobkin and Huhdanpaa, "The Quickhull algorithm for convex hulls" (ACM TOMS 1996).
//
// points    no five of which should lie on one sphere: who has lattices moves them a little
// returns   none when there are fewer than 5 points, or Qhull finds them flat
std::vector<Tetrahedron> delaunay(const std::vector<glm::dvec3>& points);

}  // namespace nlg
