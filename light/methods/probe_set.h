// The probes that all methods share: where they stand, which of them stand in air, and what light arrives there.
#pragma once

#include <vector>

#include "light/light_transport.h"
#include "runtime_eval/light_grid/probe_tree.h"

namespace nlg {

struct ProbeSetOptions {
  GatherOptions gather;
  int thread_count = 1;
  uint64_t seed = 1;
};

struct ProbeSet {
  ProbeTree tree;  // in the scene's coordinates, as positions are
  std::vector<glm::dvec3> position_m;
  std::vector<float> spacing_m;
  std::vector<uint8_t> is_in_air;
  std::vector<LightSh> light;  // gathered where each stands, in solid too
  size_t air_count = 0;
  double gather_s = 0.0;  // of the processor, summed over threads

  size_t count() const { return position_m.size(); }
};

ProbeSet makeProbeSet(const ProbeTree& tree, const LightTransport& transport, const ProbeSetOptions& options);

// Where a position lies in its cell, shares of its side along each axis, in [0, 1].
glm::dvec3 placeInCell(const ProbeTree& tree, const ProbeCell& cell, const glm::dvec3& position_m);

}  // namespace nlg
