// Where light is asked for: the air of a scene.
#pragma once

#include "datagen/visibility/ray_scene.h"
#include "datagen/visibility/solid_vote.h"

namespace nlg {

// Whether a place is neither in solid nor disputed by the rays of solid_vote.h, sky faces among the surfaces, nor in a cavity
// (cavity.h): what lies behind the sky is not air. Open ground around a model is. Any number of threads may ask at once.
// position_m   relative to the scene's origin
bool isInAir(const RayScene& rays, const glm::dvec3& position_m);
// The first half of that, by a vote that has been made with sky: cavities are not asked about.
bool isAir(const RayScene& rays, const SolidVote& vote);

}  // namespace nlg
