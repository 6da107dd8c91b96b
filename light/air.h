// Finds the air of a scene, where objects can be and light is looked up.
#pragma once

#include <string>
#include <vector>

#include "datagen/probes/probe_placement.h"
#include "datagen/visibility/ray_scene.h"
#include "datagen/visibility/solid_vote.h"
#include "scene/model/scene.h"

namespace nlg {

// The part of a scene that light fills. All boxes are relative to the scene's origin.
//
// The box around all triangles, those of the sky among them.
Bounds boundsWithSky(const Scene& scene);

// The extent of a setting, world, as probe placement takes it; where it names none, the scene's own or the box above.
ExtentBox lightExtent(const Scene& scene, const std::vector<std::string>& extent_m);

// Whether a place is neither in solid nor disputed by the rays of SolidVote, sky faces among the surfaces, nor in a cavity
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

// Whether a scene lies under the open sky.
//
// Of what an even sky sends onto the lowest ground: which share arrives, 0..1. Lowest is what faces up (by its front) and has nothing
// below that does, so that a house has its floor and not its roof. Transmissive surfaces stop nothing and are no ground. Means
// over places even in plan; the same for the same scene. 0 where lamps stand in it and none of them sees any sky: what is lit is
// inside. throws as RayScene
double openShare(const Scene& scene);

// From here on a scene is open: levels under the sky have .65 to .8, houses and mazes under .5.
inline constexpr double kOpenShare = 0.6;

}  // namespace nlg
