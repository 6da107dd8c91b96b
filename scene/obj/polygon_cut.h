// Triangulates polygons by ear clipping.
#pragma once

#include <vector>

#include <glm/glm.hpp>

namespace nlg {

struct PolygonCut {
  std::vector<glm::uvec3>
      triangles;           // of corners, wound as they are, the least first; fewer than corners - 2 where corners lie on a line
  bool holds_area = true;  // the triangles cover the outline, and nothing twice: false where it crosses itself
};

// Of an outline that may be concave, and may lead to a hole and back along one line. It need not be flat: it is cut as it is seen along
// the axis that it faces most. Of a convex one of four corners the shorter diagonal is the cut.
//
// corners   3 or more, finite. Time goes with n log n; with the square of n where the outline crosses itself everywhere
PolygonCut cutPolygon(const std::vector<glm::dvec3>& corners);

}  // namespace nlg
