// Where suns shine.
#pragma once

#include "datagen/visibility/ray_scene.h"
#include "scene/scene.h"

namespace nlg {

// Whether what a ray first met, veils apart, lets suns and sky through: nothing, or a sky face that does not shine by itself.
bool isOpenSky(const Scene& scene, const LightHit& hit);

// Whether the middle of any sun is seen from a place and stands before its plane; veils do not count.
// position_m   relative to the scene's origin
bool isInSunlight(const Scene& scene, const RayScene& rays, const glm::dvec3& position_m, const glm::vec3& normal);

}  // namespace nlg
