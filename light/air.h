// Where light is asked for: the air of a scene.
#pragma once

#include "datagen/visibility/ray_scene.h"
#include "datagen/visibility/solid_vote.h"

namespace nlg {

// Whether a place is neither in solid nor disputed by the rays of solid_vote.h, sky faces among the surfaces, nor in a cavity
// (cavity.h): what lies behind the sky is not air. Open ground around a model is. Any number of threads may ask at once.
// position_m   relative to the scene's origin
bool isInAir(const RayScene& rays, const glm::dvec3& position_m);

// The first half of that, cavities left out, for many places that are near each other: rays that cannot change what a vote comes to are
// not cast. For one thread.
class AirVoter {
 public:
  explicit AirVoter(const RayScene& rays);

  bool isAir(const glm::dvec3& position_m);
  // Of a place that is no air: whether its rays met no front, and backs enough (SolidVote::unanimous) or the outside of the sky.
  bool meetsNoFront(const glm::dvec3& position_m);

 private:
  const RayScene& rays_;
  // of the directions: those that met backs last come first, others that meetsNoFront met at the end
  std::array<uint8_t, kSolidVoteRays> order_;
};

}  // namespace nlg
