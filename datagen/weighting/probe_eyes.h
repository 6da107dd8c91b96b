// From where the probes of a lattice look: what of a neighbour decides whether it sees a point.
//
// A probe in air looks from its own place, one in solid from its eye in air (solid_eye.h), and one in solid without an eye has no function.
// Each is found when first asked for, and kept: neighbours ask for the same ones.
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <optional>
#include <unordered_map>

#include "datagen/visibility/solid_eye.h"
#include "datagen/visibility/support_visibility.h"
#include "runtime_eval/light_grid/probe_tree.h"

namespace nlg {

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

}  // namespace nlg
