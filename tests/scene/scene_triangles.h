// Triangles of a scene in world coordinates, for tests that know where they must be.
#pragma once

#include "scene/model/scene.h"

namespace nlg {

inline glm::dvec3 corner(const Scene& scene, size_t triangle, int which) {
  return scene.origin_m + glm::dvec3(scene.positions[scene.triangles[triangle][which]]);
}

// Twice as long as the triangle's area.
inline glm::dvec3 normalOf(const Scene& scene, size_t triangle) {
  const glm::dvec3 a = corner(scene, triangle, 0);
  return glm::cross(corner(scene, triangle, 1) - a, corner(scene, triangle, 2) - a);
}

}  // namespace nlg
