#include "datagen/visibility/local_triangles.h"

#include <algorithm>
#include <cmath>

namespace nlg {
namespace {

constexpr double kHalfSide = 1.0 + kBoxMargin;

double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// Does the cube lie wholly beyond the corners along this axis? (Akenine-Möller 2001)
bool separates(const glm::dvec3& axis, const glm::dvec3 corners[3]) {
  const double pa = dot(corners[0], axis), pb = dot(corners[1], axis), pc = dot(corners[2], axis);
  const double radius = kHalfSide * (std::fabs(axis.x) + std::fabs(axis.y) + std::fabs(axis.z));
  return std::min({pa, pb, pc}) > radius || std::max({pa, pb, pc}) < -radius;
}

bool boxMissesCube(const glm::dvec3 corners[3]) {
  for (int axis = 0; axis < 3; ++axis) {
    const double a = corners[0][axis], b = corners[1][axis], c = corners[2][axis];
    if (std::min({a, b, c}) > kHalfSide || std::max({a, b, c}) < -kHalfSide) return true;
  }
  return false;
}

bool edgesSeparate(const glm::dvec3 corners[3], const glm::dvec3 edges[3]) {
  const glm::dvec3 unit[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int e = 0; e < 3; ++e) {
    for (const glm::dvec3& axis : unit) {
      if (separates(glm::cross(axis, edges[e]), corners)) return true;
    }
  }
  return false;
}

void store(const glm::dvec3& vector, float* values) {
  for (int axis = 0; axis < 3; ++axis) values[axis] = static_cast<float>(vector[axis]);
}

void storeBox(const glm::dvec3 corners[3], LocalTriangle* triangle) {
  for (int axis = 0; axis < 3; ++axis) {
    const double a = corners[0][axis], b = corners[1][axis], c = corners[2][axis];
    const double low = std::clamp(std::min({a, b, c}), -4.0, 4.0), high = std::clamp(std::max({a, b, c}), -4.0, 4.0);
    triangle->center[axis] = static_cast<float>(0.5 * (low + high));
    triangle->extent[axis] = static_cast<float>(0.5 * (high - low)) + kEdgeReach;
  }
}

}  // namespace

void collectLocalTriangles(const std::vector<glm::vec3>& positions, const std::vector<glm::uvec3>& scene_triangles,
                           const std::vector<uint32_t>& candidates, const glm::dvec3& position_m, double spacing_m,
                           std::vector<LocalTriangle>* triangles) {
  const double local_from_m = 1.0 / spacing_m;
  for (const uint32_t t : candidates) {
    glm::dvec3 corners[3];
    for (int k = 0; k < 3; ++k) corners[k] = (glm::dvec3(positions[scene_triangles[t][k]]) - position_m) * local_from_m;
    if (boxMissesCube(corners)) continue;
    const glm::dvec3 edges[3] = {corners[1] - corners[0], corners[2] - corners[1], corners[0] - corners[2]};
    glm::dvec3 normal = glm::cross(edges[0], edges[1]);
    const double length = std::sqrt(dot(normal, normal));
    if (!(length > 0.0)) continue;
    normal /= length;
    if (separates(normal, corners) || edgesSeparate(corners, edges)) continue;
    LocalTriangle triangle;
    store(normal, triangle.normal);
    triangle.offset = static_cast<float>(dot(normal, corners[0]));
    for (int e = 0; e < 3; ++e) {
      const glm::dvec3 outward = glm::cross(edges[e], normal) / std::sqrt(dot(edges[e], edges[e]));
      store(outward, triangle.outward[e]);
      triangle.reach[e] = static_cast<float>(dot(outward, corners[e])) + kEdgeReach;
    }
    storeBox(corners, &triangle);
    triangles->push_back(triangle);
  }
}

}  // namespace nlg
