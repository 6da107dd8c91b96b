// A grid of nodes with a small network each, whose results are blended: the talk's last prototype before the light grid.
//
// A network reads position around its node, in [-1, 1]³ from neighbour to neighbour, and normal, and says colour. Four answer for a
// place: the corners of the tetrahedron it is in, of the six that a cell of the grid parts into along its diagonal (Kuhn). The blend is
// continuous, so that light has no edges between cells. All networks are trained together, through the blend.
#pragma once

#include "validate/light/neural/learner.h"
#include "validate/light/neural/lit_places.h"

namespace nlg {

struct NetworkGridOptions {
  double spacing_m = 4.0;  // from node to node
  int width = 16;          // of the two hidden layers
  int64_t batch = 4096;
  TrainingOptions training;
};

// Nodes that no place to learn from reads have no network: that of the nearest answers.
//
// split   learned not empty
LearnedLight trainNetworkGrid(const LitPlaces& lit, const PlaceSplit& split, const NetworkGridOptions& options);

}  // namespace nlg
