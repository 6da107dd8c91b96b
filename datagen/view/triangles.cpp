#include "datagen/view/triangles.h"

#include <cmath>

namespace nlg {

std::vector<ViewTriangle> trianglesNear(const Scene& scene, const glm::dvec3& centre_m, double unit_m, double reach) {
  std::vector<ViewTriangle> result;
  for (size_t i = 0; i < scene.triangles.size(); ++i) {
    ViewTriangle triangle;
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3 position = scene.origin_m + glm::dvec3(scene.positions[scene.triangles[i][corner]]);
      triangle.corners[corner] = (position - centre_m) / unit_m;
    }
    triangle.double_sided = scene.materials[scene.triangle_material[i]].double_sided;
    const auto& [a, b, c] = triangle.corners;
    const glm::dvec3 low = glm::min(a, glm::min(b, c)), high = glm::max(a, glm::max(b, c));
    if (glm::all(glm::lessThanEqual(low, glm::dvec3(reach))) && glm::all(glm::greaterThanEqual(high, glm::dvec3(-reach)))) {
      result.push_back(triangle);
    }
  }
  return result;
}

std::vector<CutSegment> cutTriangles(const std::vector<ViewTriangle>& triangles, int axis, double offset) {
  std::vector<CutSegment> segments;
  for (const ViewTriangle& triangle : triangles) {
    glm::dvec3 ends[2];
    int end_count = 0;
    for (int i = 0; i < 3; ++i) {
      // from the lower to the upper corner, whichever comes first: two triangles give their common edge the same point
      glm::dvec3 low = triangle.corners[i], high = triangle.corners[(i + 1) % 3];
      if (low[axis] >= offset) std::swap(low, high);
      if (low[axis] >= offset || high[axis] < offset) continue;
      glm::dvec3 end = low + (high - low) * ((offset - low[axis]) / (high[axis] - low[axis]));
      end[axis] = offset;
      ends[end_count++] = end;
    }
    if (end_count == 2 && ends[0] != ends[1]) segments.push_back({ends[0], ends[1], triangle.double_sided});
  }
  return segments;
}

bool meetsTriangle(const glm::dvec3& a, const glm::dvec3& b, const ViewTriangle& triangle) {
  const glm::dvec3 edge1 = triangle.corners[1] - triangle.corners[0], edge2 = triangle.corners[2] - triangle.corners[0];
  const glm::dvec3 step = b - a, p = glm::cross(step, edge2), s = a - triangle.corners[0];
  const double determinant = glm::dot(edge1, p);
  if (determinant == 0.0) return false;
  const double u = glm::dot(s, p) / determinant;
  if (!(u >= 0.0 && u <= 1.0)) return false;
  const glm::dvec3 q = glm::cross(s, edge1);
  const double v = glm::dot(step, q) / determinant, t = glm::dot(edge2, q) / determinant;
  return v >= 0.0 && u + v <= 1.0 && t >= 0.0 && t <= 1.0;
}

bool mayMeetBox(const ViewTriangle& triangle, const glm::dvec3& low, const glm::dvec3& high) {
  const auto& [a, b, c] = triangle.corners;
  const glm::dvec3 triangle_low = glm::min(a, glm::min(b, c)), triangle_high = glm::max(a, glm::max(b, c));
  if (glm::any(glm::greaterThan(triangle_low, high)) || glm::any(glm::lessThan(triangle_high, low))) return false;
  const glm::dvec3 normal = glm::cross(b - a, c - a), half = 0.5 * (high - low);
  return std::fabs(glm::dot(normal, 0.5 * (low + high) - a)) <= glm::dot(glm::abs(normal), half);
}

}  // namespace nlg
