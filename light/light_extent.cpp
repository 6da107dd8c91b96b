#include "light/light_extent.h"

namespace nlg {

Bounds boundsWithSky(const Scene& scene) {
  Bounds bounds = sceneBounds(scene);
  for (const glm::uvec3& triangle : scene.light.sky_faces.triangles) {
    for (int corner = 0; corner < 3; ++corner) {
      bounds.min = glm::min(bounds.min, scene.light.sky_faces.positions[triangle[corner]]);
      bounds.max = glm::max(bounds.max, scene.light.sky_faces.positions[triangle[corner]]);
    }
  }
  return bounds;
}

ExtentBox lightExtent(const Scene& scene, const std::vector<std::string>& extent_m) {
  if (const auto extent = extentFromNumbers(extent_m)) return {extent->low_m - scene.origin_m, extent->high_m - scene.origin_m};
  if (scene.extent) return {scene.extent->low_m - scene.origin_m, scene.extent->high_m - scene.origin_m};
  const Bounds bounds = boundsWithSky(scene);
  return {glm::dvec3(bounds.min), glm::dvec3(bounds.max)};
}

}  // namespace nlg
