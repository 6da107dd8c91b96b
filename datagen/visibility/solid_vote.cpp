#include "datagen/visibility/solid_vote.h"

#include <algorithm>

#include "datagen/visibility/cavity.h"

namespace nlg {

// 14 directions: the axes and diagonals of a cube, turned so that none runs along the walls of axis-aligned levels.
const std::array<glm::vec3, kSolidVoteRays>& voteDirections() {
  static const std::array<glm::vec3, kSolidVoteRays> directions = [] {
    std::array<glm::vec3, kSolidVoteRays> result;
    int count = 0;
    const glm::vec3 x(0.8018f, 0.5345f, 0.2673f), y(-0.5774f, 0.5774f, 0.5774f);
    const glm::vec3 z = glm::cross(x, y);
    for (const float sign : {-1.0f, 1.0f}) {
      for (const glm::vec3& axis : {x, y, z}) result[count++] = sign * axis;
    }
    for (int corner = 0; corner < 8; ++corner) {
      const auto sign = [&](int bit) { return corner >> bit & 1 ? 1.0f : -1.0f; };
      result[count++] = glm::normalize(sign(0) * x + sign(1) * y + sign(2) * z);
    }
    return result;
  }();
  return directions;
}

namespace {

template <class FirstFacing>
SolidVote voteOf(const FirstFacing& first_facing) {
  SolidVote vote;
  for (const glm::vec3& direction : voteDirections()) {
    const Facing facing = first_facing(direction);
    vote.front += facing == Facing::front;
    vote.back += facing == Facing::back;
    vote.nothing += facing == Facing::nothing;
  }
  return vote;
}

// High in a level rays pass over its rim and meet walls from outside: the sky stands between, and they are no evidence.
SolidVote raysAt(const RayScene& rays, const glm::dvec3& position_m) {
  const SolidVote vote = solidVote(rays, position_m);
  if (!vote.solid() || !rays.hasSkyFaces()) return vote;
  const SolidVote under_sky = solidVoteWithSky(rays, position_m);
  return under_sky.solid() ? vote : under_sky;
}

}  // namespace

SolidVote solidVote(const RayScene& rays, const glm::dvec3& position_m) {
  return voteOf([&](const glm::vec3& direction) { return rays.firstFacing(glm::vec3(position_m), direction); });
}

SolidVote solidVoteWithSky(const RayScene& rays, const glm::dvec3& position_m) {
  return voteOf([&](const glm::vec3& direction) { return rays.firstFacingWithSky(glm::vec3(position_m), direction); });
}

SolidVote withCavity(SolidVote vote, const RayScene& rays, const glm::dvec3& position_m) {
  vote.in_cavity = !vote.solid() && isInCavity(rays, position_m);
  return vote;
}

SolidVote voteAt(const RayScene& rays, const glm::dvec3& position_m) {
  return withCavity(raysAt(rays, position_m), rays, position_m);
}

SolidVote groupVote(const RayScene& rays, size_t count, const std::function<glm::dvec3(size_t member)>& place_of) {
  SolidVote total;
  const size_t stride = std::max<size_t>(1, count / 3);
  for (size_t member = 0; member < count && !total.unanimous(); member += stride) {
    const SolidVote one = raysAt(rays, place_of(member));
    total.front += one.front;
    total.back += one.back;
  }
  return total;
}

}  // namespace nlg
