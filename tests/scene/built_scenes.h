// Scenes of one material, put together of quads: floors, boxes, rooms.
#pragma once

#include "scene/model/scene.h"

namespace nlg {

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
