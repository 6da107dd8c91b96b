// Whether a scene lies under the open sky.
#pragma once

#include "scene/scene.h"

namespace nlg {

// Of what an even sky sends onto the lowest ground: which share arrives, 0..1. Lowest is what faces up (by its front) and has nothing
// below that does, so that a house has its floor and not its roof. Veils stop nothing and are no ground. Means over places even in
// plan; the same for the same scene. 0 where lamps stand in it and none of them sees any sky: what is lit is inside. throws as
// RayScene
double openShare(const Scene& scene);

// From here on a scene is open: levels under the sky have .65 to .8, houses and mazes under .5.
inline constexpr double kOpenShare = 0.6;

}  // namespace nlg
