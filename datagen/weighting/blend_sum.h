// Computes S, the sum of the functions of all probes of a cell at the support points of one of them, by which the loss weighs
// lit points (runtime_eval/support/weighting_function.h).
//
// A support is eight cells of the probe's spacing, an octant each, and the probe shares each with seven others. Theirs are taken as their
// tents where their eye sees a point, and as 0 elsewhere: what diffusion carries round corners is left out, and so are cells of
// another level. Only the triangles of the probe's own support are asked: a neighbour in air sees the octant from its corner, so that no
// other can stand between; of one in solid, whose eye may lie beyond the support, a triangle out there is missed.
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

#include "datagen/visibility/segment_kernel.h"
#include "datagen/visibility/solid_eye.h"
#include "datagen/visibility/support_visibility.h"
#include "nlg/probe_tree.h"

namespace nlg {

// From where the probes of a lattice look: what of a neighbour decides whether it sees a point.
//
// A probe in air looks from its own place, one in solid from its eye in air (solid_eye.h), and one in solid without an eye has no function.
// Each is found when first asked for, and kept: neighbours ask for the same ones.

// Of one probe.
struct ProbeSight {
  SolidVote vote;                 // of its own place
  std::optional<LocalPoint> eye;  // in its own local coordinates; nothing where it has no function
};

// What one thread takes to find an eye.
class EyeFinder {
 public:
  // Both must outlive this object.
  EyeFinder(const RayScene& scene, const LinkTable& links) : visibility_(scene, links) {}

  // position_m   relative to the scene's origin; spacing_m > 0
  ProbeSight find(const glm::dvec3& position_m, float spacing_m);

 private:
  SupportVisibility visibility_;
  SolidEye solid_eye_;
};

// Any number of threads may ask, each with a finder of its own; the answers are the same for any number and order.
class ProbeEyes {
 public:
  explicit ProbeEyes(const ProbeTreeFrame& lattice) : lattice_(lattice) {}

  // The lattice point nearest to a position.
  LatticePoint latticeOf(const glm::dvec3& position_m) const;
  int32_t unitsOf(float spacing_m) const;
  // Of the probe at a lattice point, inside or outside the tree, of a spacing of `units`.
  ProbeSight sightOf(const LatticePoint& at, int32_t units, EyeFinder* finder);

 private:
  using Key = std::array<int32_t, 4>;
  struct KeyHash {
    size_t operator()(const Key& key) const;
  };
  struct Part {
    std::mutex mutex;
    std::unordered_map<Key, ProbeSight, KeyHash> sights;
  };
  static constexpr size_t kParts = 64;  // threads seldom wait for each other
  static constexpr size_t kMostKept =
      65536;  // of a part; then it begins anew: probes are visited along a curve, and few are asked for again

  ProbeTreeFrame lattice_;
  std::array<Part, kParts> parts_;
};

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
