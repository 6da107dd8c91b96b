#include "light/methods/tetrahedra.h"

#include <algorithm>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

// Of the spacing: what breaks the lattice's ties and is not seen.
constexpr double kMove = 1e-3;
// Below zero by rounding alone.
constexpr double kInside = -1e-9;

}  // namespace

std::unique_ptr<Tetrahedra> Tetrahedra::make(const ProbeSet& probes) {
  std::unique_ptr<Tetrahedra> made(new Tetrahedra(probes));
  Random random(1);
  for (uint32_t p = 0; p < probes.count(); ++p) {
    if (!probes.is_in_air[p]) continue;
    glm::dvec3 position = probes.position_m[p];
    for (int axis = 0; axis < 3; ++axis) position[axis] += kMove * probes.spacing_m[p] * random.uniform(-1.0, 1.0);
    made->probe_.push_back(p);
    made->positions_m_.push_back(position);
  }
  made->cell_of_probe_.assign(probes.count(), kNoTetrahedron);
  for (const Tetrahedron& corners : delaunay(made->positions_m_)) {
    const auto at = [&](int i) { return made->positions_m_[corners.vertex[i]]; };
    for (const uint32_t vertex : corners.vertex)
      made->cell_of_probe_[made->probe_[vertex]] = static_cast<uint32_t>(made->cells_.size());
    made->cells_.push_back({corners, glm::inverse(glm::dmat3(at(0) - at(3), at(1) - at(3), at(2) - at(3)))});
  }
  if (made->cells_.empty()) return nullptr;
  return made;
}

uint32_t Tetrahedra::nearbyCell(const glm::dvec3& position_m) const {
  ProbesAround around;
  if (!probes_.tree.lookUp({position_m.x, position_m.y, position_m.z}, &around)) return 0;
  for (const ProbeAround& corner : around.corners) {
    if (cell_of_probe_[corner.probe] != kNoTetrahedron) return cell_of_probe_[corner.probe];
  }
  return 0;
}

std::array<double, 4> Tetrahedra::shares(const Cell& cell, const glm::dvec3& position_m) const {
  const glm::dvec3 first = cell.shares_from_way * (position_m - positions_m_[cell.corners.vertex[3]]);
  return {first.x, first.y, first.z, 1.0 - first.x - first.y - first.z};
}

// Through the face that the position lies furthest behind. Faces of the hull lead nowhere, but the others may still: a walk to a
// position outside goes on along the hull until it stands below it.
uint32_t Tetrahedra::nextTowards(const Cell& cell, const std::array<double, 4>& share) {
  uint32_t next = kNoTetrahedron;
  double least = kInside;
  for (int i = 0; i < 4; ++i) {
    if (share[i] >= least || cell.corners.neighbour[i] == kNoTetrahedron) continue;
    least = share[i];
    next = cell.corners.neighbour[i];
  }
  return next;
}

ProbeBlend Tetrahedra::blendAt(const glm::dvec3& position_m, const glm::vec3&) const {
  ProbeBlend blend;
  uint32_t at = nearbyCell(position_m);
  // a walk through a Delaunay triangulation never comes back, but for what rounding makes of slivers
  for (size_t step = 0;; ++step) {
    const Cell& cell = cells_[at];
    const std::array<double, 4> share = shares(cell, position_m);
    const uint32_t next = nextTowards(cell, share);
    if (next != kNoTetrahedron && step < cells_.size()) {
      at = next;
      continue;
    }
    const bool is_inside = *std::min_element(share.begin(), share.end()) >= kInside;
    for (int i = 0; i < 4; ++i) blend.add(probe_[cell.corners.vertex[i]], static_cast<float>(share[i]));
    blend.finish(is_inside ? Reach::lit : Reach::outside);
    return blend;
  }
}

}  // namespace nlg
