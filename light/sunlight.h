// Where suns shine.
#pragma once

#include "datagen/visibility/ray_scene.h"
#include "scene/scene.h"

namespace nlg {

// Whether suns and sky send light this way, veils apart: what it meets first is nothing, or a sky face that does not shine by itself.
// from   relative to the scene's origin
bool comesFromOpenSky(const Scene& scene, const RayScene& rays, const glm::vec3& from, const glm::vec3& direction);

// Whether the middle of any sun is seen from a place and stands before its plane; veils do not count.
// position_m   relative to the scene's origin
bool isInSunlight(const Scene& scene, const RayScene& rays, const glm::dvec3& position_m, const glm::vec3& normal);

}  // namespace nlg
