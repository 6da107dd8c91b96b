// Barycentric blends in tetrahedra of probes in air. Cupisz, "Light probe interpolation using tetrahedral tessellations" (GDC
// 2012).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <glm/glm.hpp>

#include "light/methods/light_method.h"

namespace nlg {

inline constexpr uint32_t kNoTetrahedron = 0xffffffffu;

struct Tetrahedron {
  std::array<uint32_t, 4> vertex{};     // index into the points
  std::array<uint32_t, 4> neighbour{};  // the one that shares the other three vertices; kNoTetrahedron at the hull
};

// Delaunay tetrahedra of points in space, by Qhull. Barber, Dobkin and Huhdanpaa, "The Quickhull algorithm for convex hulls" (ACM
// TOMS 1996).
//
// points    no five of which should lie on one sphere: who has lattices moves them a little
// returns   none when there are fewer than 5 points, or Qhull finds them flat
std::vector<Tetrahedron> delaunay(const std::vector<glm::dvec3>& points);

class Tetrahedra : public Weighting {
 public:
  // probes must outlive the object.
  // returns   nothing where probes in air are too few for a tetrahedron
  static std::unique_ptr<Tetrahedra> make(const ProbeSet& probes);

  // Outside the hull: of the last tetrahedron on the way there, shares below 0 left out.
  ProbeBlend blendAt(const glm::dvec3& position_m, const glm::vec3& normal) const override;

  // 4 vertices, 4 neighbours and a 3 x 3 matrix of floats a tetrahedron, 3 floats a probe.
  size_t byteCount() const { return cells_.size() * (4 * 4 + 4 * 4 + 9 * 4) + positions_m_.size() * 3 * 4; }

 private:
  struct Cell {
    Tetrahedron corners;
    glm::dmat3 shares_from_way;  // of the first three corners, from the way that leads here from the fourth
  };

  explicit Tetrahedra(const ProbeSet& probes) : probes_(probes) {}
  uint32_t nearbyCell(const glm::dvec3& position_m) const;
  std::array<double, 4> shares(const Cell& cell, const glm::dvec3& position_m) const;
  static uint32_t nextTowards(const Cell& cell, const std::array<double, 4>& share);

  const ProbeSet& probes_;
  std::vector<uint32_t> probe_;          // by vertex
  std::vector<glm::dvec3> positions_m_;  // by vertex: the probe's, moved a little
  std::vector<Cell> cells_;
  std::vector<uint32_t> cell_of_probe_;  // one that has it as a corner; kNoTetrahedron where none has
};

}  // namespace nlg
