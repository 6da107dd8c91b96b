#include "datagen/visibility/support_visibility.h"

#include <algorithm>

#include "datagen/visibility/segment_kernel.h"

namespace nlg {

SupportVisibility::SupportVisibility(const RayScene& scene) : scene_(scene), blocked_(supportPackets().tree.packetCount()) {}

void SupportVisibility::beginProbe(const glm::dvec3& position_m, float spacing_m) {
  position_ = position_m;
  spacing_ = spacing_m;
  triangles_.clear();
  scene_.trianglesNearCube(glm::vec3(position_m), spacing_m, &candidates_);
  collectLocalTriangles(scene_.positions(), scene_.triangles(), candidates_, position_m, spacing_, &triangles_);
}

glm::dvec3 SupportVisibility::placeOf(const LocalPoint& local) const {
  return position_ + spacing_ * glm::dvec3(local[0], local[1], local[2]);
}

void SupportVisibility::traceRays(const LocalPoint& eye) {
  eye_ = eye;
  blockRays(supportPackets(), triangles_, eye, blocked_.data());
}

bool SupportVisibility::isOpen(const LocalPoint& from, const LocalPoint& to) const {
  return std::none_of(triangles_.begin(), triangles_.end(),
                      [&](const LocalTriangle& triangle) { return segmentMeets(triangle, from, to); });
}

}  // namespace nlg
