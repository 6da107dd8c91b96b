// Chooses the eye of a probe in solid: the point of its support from which its visibility is computed.
//
// From inside a wall nothing can be seen. Instead of the probe's own place a place in air is taken, of a fixed set of candidates
// the one that sees most of the support, by the tent, as far as what it sees is one: the probe then lights one side of a wall, the
// one that matters more to it. From a window or a doorway most is seen, and two rooms would have the mean of their light.
// After the talk's probes in geometry, by geometry alone (docs/theory/probes.md).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "datagen/visibility/segment_kernel.h"
#include "datagen/visibility/support_visibility.h"

namespace nlg {

// Support points, in mirror images of one another: first those to choose from, denser towards the probe; then, for probes of
// which none of these is in air, those near the support's border.
inline constexpr int kEyeCandidateCount = 64;
enum class EyeRing { inner, outer };
const std::vector<uint32_t>& eyeCandidates(EyeRing ring);

class SolidEye {
 public:
  SolidEye();

  // The eye of the probe that `visibility` has begun, and traces its rays; nothing when no candidate is in air. The same for the
  // same probe, whatever was asked before. A support without triangles is all in solid, as its probe is: there is no eye.
  std::optional<LocalPoint> open(SupportVisibility* visibility);

 private:
  using Set = uint64_t;  // of a ring's candidates, a bit each

  // The candidates of a ring, and what they see of each other.
  struct Candidates {
    explicit Candidates(EyeRing ring);
    void findVisible(const SupportVisibility& visibility, LinkScratch* scratch);
    Set reachedFrom(int candidate) const;
    Set inAir(const SupportVisibility& visibility) const;

    const std::vector<uint32_t>& points;
    LinkPackets pairs;         // of candidates, by their numbers
    std::vector<Set> visible;  // by candidate: itself and those that it sees
    std::vector<uint16_t> blocked;
  };

  struct Promise {
    double seen, oneness;  // tents that it sees of other candidates, times oneness; that is in (0, 1]
    uint64_t own;          // its tent
    int candidate;
  };
  double onenessOf(const Candidates& candidates, Set set) const;
  std::vector<Promise> promising(const Candidates& candidates, const SupportVisibility& visibility) const;
  uint64_t darkTents(const SupportVisibility& visibility) const;

  std::vector<uint64_t> tent_;  // by support point, in units of 2^-32: sums do not depend on their order
  uint64_t all_tents_ = 0;
  Candidates inner_, outer_;
  LinkScratch scratch_;
};

}  // namespace nlg
