#include "light/air.h"

#include "datagen/visibility/cavity.h"

namespace nlg {

bool isInAir(const RayScene& rays, const glm::dvec3& position_m) {
  return isAir(rays, solidVoteWithSky(rays, position_m)) && !isInCavity(rays, position_m);
}

bool isAir(const RayScene& rays, const SolidVote& vote) {
  // a level with faces of sky is closed by them: where most rays leave it, they never were inside
  if (rays.hasSkyFaces() && 2 * vote.nothing > kSolidVoteRays) return false;
  return !vote.solid() && !vote.disputed();
}

}  // namespace nlg
