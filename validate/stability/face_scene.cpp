#include "validate/stability/face_scene.h"

namespace nlg {

void FaceScene::addTriangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, Sides sides) {
  positions_.insert(positions_.end(), {a, b, c});
  materials_.push_back(static_cast<uint32_t>(sides));
}

void FaceScene::addQuad(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d, Sides sides) {
  addTriangle(a, b, c, sides);
  addTriangle(a, c, d, sides);
}

void FaceScene::addBox(const glm::dvec3& low, const glm::dvec3& high, bool flipped) {
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const bool far_side : {false, true}) {
      glm::dvec3 a = low;
      a[axis] = far_side ? high[axis] : low[axis];
      glm::dvec3 b = a, c = a, d = a;
      b[u] = c[u] = high[u];
      c[v] = d[v] = high[v];
      if (far_side != flipped) {
        addQuad(a, b, c, d);
      } else {
        addQuad(a, d, c, b);
      }
    }
  }
}

Scene FaceScene::finish() const {
  Scene scene;
  scene.id = "stability";
  scene.materials.resize(2);
  scene.materials[1].double_sided = true;
  scene.triangle_material = materials_;
  for (uint32_t t = 0; t < materials_.size(); ++t) scene.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  if (!materials_.empty()) scene.objects.push_back({"all", 0, static_cast<uint32_t>(materials_.size()), false});
  finishScene(scene, positions_);
  return scene;
}

}  // namespace nlg
