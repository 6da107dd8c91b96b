// Scenes of one material, put together of quads: floors, boxes, rooms.
#pragma once

#include <array>
#include <vector>

#include "scene/model/scene.h"

namespace nlg {

// The sides of a box, wound outward: low and high of x, of y, of z.
inline std::vector<std::array<glm::vec3, 4>> boxSides(const glm::vec3& low, const glm::vec3& high) {
  std::vector<std::array<glm::vec3, 4>> sides;
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const bool is_far : {false, true}) {
      glm::vec3 a = low;
      a[axis] = is_far ? high[axis] : low[axis];
      glm::vec3 b = a, c = a, d = a;
      b[u] = c[u] = high[u];
      c[v] = d[v] = high[v];
      sides.push_back(is_far ? std::array{a, b, c, d} : std::array{a, d, c, b});
    }
  }
  return sides;
}

inline Scene sceneOfMaterial(bool double_sided) {
  Scene scene;
  Material material;
  material.double_sided = double_sided;
  scene.materials.push_back(material);
  return scene;
}

// From a corner along u and v, facing the way of cross(u, v).
inline void addQuad(Scene& scene, const glm::vec3& corner, const glm::vec3& u, const glm::vec3& v) {
  const auto first = static_cast<uint32_t>(scene.positions.size());
  scene.positions.insert(scene.positions.end(), {corner, corner + u, corner + u + v, corner + v});
  scene.triangles.insert(scene.triangles.end(), {{first, first + 1, first + 2}, {first, first + 2, first + 3}});
  scene.triangle_material.insert(scene.triangle_material.end(), 2, 0);
}

// A solid box, facing out.
inline void addBox(Scene& scene, const glm::vec3& low, const glm::vec3& high) {
  const glm::vec3 x(high.x - low.x, 0, 0), y(0, high.y - low.y, 0), z(0, 0, high.z - low.z);
  addQuad(scene, low, y, x), addQuad(scene, low, z, y), addQuad(scene, low, x, z);
  addQuad(scene, high, -x, -y), addQuad(scene, high, -y, -z), addQuad(scene, high, -z, -x);
}

// The same facing in.
inline void addRoom(Scene& scene, const glm::vec3& low, const glm::vec3& high) {
  const size_t first = scene.triangles.size();
  addBox(scene, low, high);
  for (size_t t = first; t < scene.triangles.size(); ++t) std::swap(scene.triangles[t].y, scene.triangles[t].z);
}

}  // namespace nlg
