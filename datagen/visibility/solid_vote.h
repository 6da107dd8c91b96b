// Whether a place lies in solid, by rays from it.
#pragma once

#include <array>
#include <functional>

#include <glm/glm.hpp>

#include "datagen/visibility/ray_scene.h"

namespace nlg {

// How rays from a place, or from several that stand for a group, judged it.
struct SolidVote {
  int front = 0, back = 0;
  int nothing = 0;         // rays that met no face
  bool in_cavity = false;  // no solid by its rays, but where nobody can be: withCavity
  // solid from two fifths of backs on: on real and procedural levels shares of backs lie below a tenth or above two fifths,
  // seldom between, and exactly a half is common inside a slab that rests on another one (docs/theory/visibility.md)
  bool solid() const { return in_cavity || (back > 0 && 5 * back >= 2 * (front + back)); }
  // a share of backs in that gap: open, flipped or self-intersecting geometry
  bool disputed() const { return 10 * back > front + back && !solid(); }
  // at least seven rays met a one-sided face, all of them the same side
  bool unanimous() const { return front + back >= 7 && (front == 0 || back == 0); }
};

inline constexpr int kSolidVoteRays = 14;

// The directions of a vote's rays.
const std::array<glm::vec3, kSolidVoteRays>& voteDirections();

// The rays of one place against the scene's surfaces.
// position_m   relative to the scene's origin, here and below
SolidVote solidVote(const RayScene& rays, const glm::dvec3& position_m);

// The same with sky faces among the surfaces: what lies behind the sky is no part of the scene.
SolidVote solidVoteWithSky(const RayScene& rays, const glm::dvec3& position_m);

// What is no solid by its rays lies in a cavity (cavity.h), or does not.
SolidVote withCavity(SolidVote vote, const RayScene& rays, const glm::dvec3& position_m);

// What a place is to probes and functions: a vote for solid holds where it does with sky faces, too, and what lies in a cavity (cavity.h)
// is solid.
SolidVote voteAt(const RayScene& rays, const glm::dvec3& position_m);

// The rays of up to five members of a group together, that stand for all of it: the first alone when its rays leave no doubt. Cavities are
// not asked: withCavity, for any member.
// count      of members, at least 1
// place_of   the place of a member
SolidVote groupVote(const RayScene& rays, size_t count, const std::function<glm::dvec3(size_t member)>& place_of);

}  // namespace nlg
