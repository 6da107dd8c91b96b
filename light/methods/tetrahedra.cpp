#include "light/methods/tetrahedra.h"

#include <algorithm>
#include <cstdio>
#include <unordered_map>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

// Qhull's own state; it says what it has to say to a file, here to none.
class Qhull {
 public:
  Qhull() : quiet_(std::fopen("/dev/null", "w")) { qh_zero(&state_, quiet_); }
  ~Qhull() {
    qh_freeqhull(&state_, qh_ALL);
    int left = 0, total = 0;
    qh_memfreeshort(&state_, &left, &total);
    if (quiet_ != nullptr) std::fclose(quiet_);
  }
  Qhull(const Qhull&) = delete;
  Qhull& operator=(const Qhull&) = delete;

  bool triangulate(std::vector<double>& coordinates) {
    // d: Delaunay; Qt: tetrahedra also where points share a sphere; Qbb Qc: its defaults for Delaunay
    char command[] = "qhull d Qt Qbb Qc";
    return quiet_ != nullptr && qh_new_qhull(&state_, 3, static_cast<int>(coordinates.size() / 3), coordinates.data(), False,
                                             command, quiet_, quiet_) == qh_ERRnone;
  }

  std::vector<Tetrahedron> tetrahedra() {
    qhT* qh = &state_;
    std::unordered_map<unsigned, uint32_t> number;  // by Qhull's
    facetT* facet;
    FORALLfacets {
      if (!facet->upperdelaunay) number.emplace(facet->id, static_cast<uint32_t>(number.size()));
    }
    std::vector<Tetrahedron> result;
    result.reserve(number.size());
    FORALLfacets {
      if (facet->upperdelaunay) continue;
      Tetrahedron& made = result.emplace_back();
      // of simplices vertices and the neighbours over against them stand in the same order
      for (int i = 0; i < 4; ++i) {
        const auto* vertex = SETelemt_(facet->vertices, i, vertexT);
        const auto* neighbour = SETelemt_(facet->neighbors, i, facetT);
        made.vertex[i] = static_cast<uint32_t>(qh_pointid(qh, vertex->point));
        made.neighbour[i] = neighbour->upperdelaunay ? kNoTetrahedron : number.at(neighbour->id);
      }
    }
    return result;
  }

 private:
  qhT state_{};
  FILE* quiet_;
};

// Of the spacing: what breaks the lattice's ties and is not seen.
constexpr double kMove = 1e-3;
// Below zero by rounding alone.
constexpr double kInside = -1e-9;

}  // namespace

std::vector<Tetrahedron> delaunay(const std::vector<glm::dvec3>& points) {
  if (points.size() < 5) return {};
  std::vector<double> coordinates;
  for (const glm::dvec3& point : points) coordinates.insert(coordinates.end(), {point.x, point.y, point.z});
  Qhull qhull;
  if (!qhull.triangulate(coordinates)) return {};
  return qhull.tetrahedra();
}

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
