#include "light/sunlight.h"

#include <algorithm>

namespace nlg {

bool comesFromOpenSky(const Scene& scene, const RayScene& rays, const glm::vec3& from, const glm::vec3& direction) {
  if (!rays.hasSkyFaces()) return !rays.isOpaqueAlong(from, direction);  // what it meets need not be known
  const LightHit hit = rays.lightHit(from, direction);
  return hit.kind == LightHit::Kind::nothing || (hit.kind == LightHit::Kind::sky && !scene.light.sky_faces.shines(hit.triangle));
}

bool isInSunlight(const Scene& scene, const RayScene& rays, const glm::dvec3& position_m, const glm::vec3& normal) {
  const std::vector<Sun>& suns = scene.light.suns;
  return std::any_of(suns.begin(), suns.end(), [&](const Sun& sun) {
    return glm::dot(sun.to_sun, normal) > 0.0f && comesFromOpenSky(scene, rays, glm::vec3(position_m), sun.to_sun);
  });
}

}  // namespace nlg
