// The eye of a probe in solid: the place of its support from which is judged what the probe sees.
//
// From inside a wall nothing can be seen. Instead of the probe's own place a place in air is taken, of a fixed set of candidates
// the one that sees most of the support, by the tent: the probe then lights one side of a wall, the one that matters more to it.
// After the talk's probes in geometry, by geometry alone (docs/theory/probes.md).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "datagen/visibility/support_visibility.h"

namespace nlg {

// Support points, in mirror images of one another, denser towards the probe.
inline constexpr int kEyeCandidateCount = 64;
const std::vector<uint32_t>& eyeCandidates();

class SolidEye {
 public:
  SolidEye();

  // The eye of the probe that `visibility` has begun, and traces its rays; nothing when no candidate is in air, or the support
  // holds no triangle. The same for the same probe, whatever was asked before.
  std::optional<LocalPoint> open(SupportVisibility* visibility);

 private:
  using Set = uint64_t;  // of candidates, a bit each

  void findVisible(const SupportVisibility& visibility);
  Set reachedFrom(int candidate) const;
  Set inAir(const SupportVisibility& visibility) const;
  std::vector<int> promising(Set air) const;
  uint64_t seenTents(const SupportVisibility& visibility) const;

  LinkPackets pairs_;           // of candidates, by their numbers
  std::vector<uint64_t> tent_;  // by support point, in units of 2^-32: sums do not depend on their order
  std::vector<Set> visible_;    // by candidate: itself and those that it sees
  std::vector<uint16_t> blocked_;
  LinkScratch scratch_;
};

}  // namespace nlg
