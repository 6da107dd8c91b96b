#include "datagen/lighting/air.h"

#include "datagen/visibility/solid_vote.h"

namespace nlg {

bool isInAir(const RayScene& rays, const glm::dvec3& position_m) {
  const SolidVote vote = solidVoteWithSky(rays, position_m);
  return !vote.solid() && !vote.disputed();
}

}  // namespace nlg
