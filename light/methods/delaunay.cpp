#include "light/methods/delaunay.h"

#include <cstdio>
#include <memory>
#include <unordered_map>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

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

}  // namespace

std::vector<Tetrahedron> delaunay(const std::vector<glm::dvec3>& points) {
  if (points.size() < 5) return {};
  std::vector<double> coordinates;
  for (const glm::dvec3& point : points) coordinates.insert(coordinates.end(), {point.x, point.y, point.z});
  Qhull qhull;
  if (!qhull.triangulate(coordinates)) return {};
  return qhull.tetrahedra();
}

}  // namespace nlg
