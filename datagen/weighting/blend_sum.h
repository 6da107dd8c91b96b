// S, the sum of the functions of all probes of a cell at the support points of one of them: what the loss weighs lit points by
// (runtime_eval/support/loss_weights.h).
//
// A support is eight cells of the probe's spacing, an octant each, and the probe shares each with seven others. Theirs are taken as their
// tents where their eye sees a point, and as 0 elsewhere: what diffusion carries round corners is left out, and so are cells of
// another level. Only the triangles of the probe's own support are asked: a neighbour in air sees the octant from its corner, so that no
// other can stand between; of one in solid, whose eye may lie beyond the support, a triangle out there is missed.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "datagen/visibility/segment_kernel.h"
#include "datagen/weighting/probe_eyes.h"

namespace nlg {

// Of a probe and those around it, by where they stand: offset (x, y, z) in -1 … 1 at index (x + 1) + 3 (y + 1) + 9 (z + 1); in their own
// local coordinates. Nothing where one has no function.
using NeighbourEyes = std::array<std::optional<LocalPoint>, 27>;
NeighbourEyes neighbourEyes(const glm::dvec3& position_m, float spacing_m, ProbeEyes* eyes, EyeFinder* finder);

// One of these a thread.
class BlendSum {
 public:
  BlendSum();

  // triangles   of the support
  // phi         P, or more: the rest is not read
  // sums        P, overwritten: round(255 min(1, S)) at lit points, 255 where phi is 0
  void compute(const std::vector<LocalTriangle>& triangles, const NeighbourEyes& eyes, const float* phi, uint8_t* sums);

 private:
  void addNeighbour(int mirror, int away, const LocalPoint& eye, bool in_place, const std::vector<LocalTriangle>& triangles);

  std::array<OctantPackets, kMirrorCount> octants_;
  std::array<AlignedFloats, kMirrorCount>
      tents_;                  // by axes along which a neighbour is away, bits: its tent at an octant's points
  std::vector<uint32_t> all_;  // triangles of the support …
  std::array<std::vector<uint32_t>, kMirrorCount> near_;  // … and of each octant
  std::array<uint16_t, kOctantPointCount / kPacketLanes> blocked_{};
  AlignedFloats sum_;  // of one octant
};

}  // namespace nlg
