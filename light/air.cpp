#include "light/air.h"

#include <algorithm>
#include <numeric>

#include "datagen/visibility/cavity.h"

namespace nlg {
namespace {

// A level with faces of sky is closed by them: where most rays leave it, they never were inside.
bool isOutside(const RayScene& rays, int nothing) { return rays.hasSkyFaces() && 2 * nothing > kSolidVoteRays; }

}  // namespace

bool isInAir(const RayScene& rays, const glm::dvec3& position_m) {
  return AirVoter(rays).isAir(position_m) && !isInCavity(rays, position_m);
}

AirVoter::AirVoter(const RayScene& rays) : rays_(rays) { std::iota(order_.begin(), order_.end(), uint8_t{0}); }

bool AirVoter::isAir(const glm::dvec3& position_m) {
  SolidVote vote;
  for (int i = 0; i < kSolidVoteRays; ++i) {
    const Facing facing = rays_.firstBackWithSky(glm::vec3(position_m), voteDirections()[order_[i]]);
    vote.nothing += facing == Facing::nothing;
    if (isOutside(rays_, vote.nothing)) return false;
    if (facing != Facing::back) continue;
    ++vote.back;
    std::rotate(order_.begin(), order_.begin() + i, order_.begin() + i + 1);
    // were all others fronts, it would be disputed
    if (10 * vote.back > kSolidVoteRays) return false;
  }
  if (vote.back == 0) return true;
  const SolidVote whole = solidVoteWithSky(rays_, position_m);
  return !whole.solid() && !whole.disputed();
}

bool AirVoter::meetsNoFront(const glm::dvec3& position_m) {
  SolidVote vote;
  for (int i = kSolidVoteRays - 1, others = 0; i >= 0; --i) {
    const Facing facing = rays_.firstFacingWithSky(glm::vec3(position_m), voteDirections()[order_[i]]);
    vote.back += facing == Facing::back;
    vote.nothing += facing == Facing::nothing;
    if (facing == Facing::back) continue;
    std::rotate(order_.begin() + i, order_.begin() + i + 1, order_.end());
    // fewer faces than are asked for
    if (facing == Facing::front || (2 * ++others > kSolidVoteRays && !rays_.hasSkyFaces())) return false;
  }
  return vote.unanimous() || isOutside(rays_, vote.nothing);
}

}  // namespace nlg
