// Locates a point among the nodes of a trilinear grid over [-1, 1]³, for product fields and bricks.
#pragma once

#include <algorithm>

#include "nlg/support.h"

namespace nlg {

// The cell of r³ nodes that holds a point, and the point's share of the way through it.
struct NodePlace {
  int node[3];  // at the cell's low corner, 0 … r - 2
  float share[3];
};

// The point is limited to the cube; what is no number lies in the first cell.
inline NodePlace placeAmongNodes(int resolution, const LocalPoint& point) {
  NodePlace place;
  for (int axis = 0; axis < 3; ++axis) {
    const float position = std::clamp((point[axis] + 1.0f) * 0.5f, 0.0f, 1.0f) * static_cast<float>(resolution - 1);
    place.node[axis] = position > 0.0f ? std::min(static_cast<int>(position), resolution - 2) : 0;
    place.share[axis] = position - static_cast<float>(place.node[axis]);
  }
  return place;
}

}  // namespace nlg
