// Triangles of a scene in world coordinates, for tests that know where they must be.
#pragma once

#include <gtest/gtest.h>

#include <string>

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

inline void expectNear(const glm::dvec3& got, const glm::dvec3& expected, const std::string& what, double most = 1e-6) {
  EXPECT_LT(glm::length(got - expected), most) << what << ": " << got.x << " " << got.y << " " << got.z;
}

// What an object encloses; below 0 where its faces look inward.
inline double volumeOf(const Scene& scene, const SceneObject& object) {
  double volume = 0.0;
  for (uint32_t i = object.first_triangle; i < object.first_triangle + object.triangle_count; ++i) {
    const glm::uvec3& t = scene.triangles[i];
    const glm::dvec3 a(scene.positions[t.x]), b(scene.positions[t.y]), c(scene.positions[t.z]);
    volume += glm::dot(a, glm::cross(b, c)) / 6.0;
  }
  return volume;
}

}  // namespace nlg
