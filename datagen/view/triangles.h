// A scene's triangles in the coordinates of a picture, and their intersections with its planes and segments.
#pragma once

#include <array>
#include <vector>

#include <glm/glm.hpp>

#include "scene/scene.h"

namespace nlg {

struct ViewTriangle {
  std::array<glm::dvec3, 3> corners;
  bool double_sided = false;
};

// The triangles whose bounding box meets the cube [-reach, reach]³ of local coordinates (position - centre) / unit.
// centre_m   in the world, metres; unit_m > 0: what becomes 1
std::vector<ViewTriangle> trianglesNear(const Scene& scene, const glm::dvec3& centre_m, double unit_m, double reach);

struct CutSegment {
  glm::dvec3 a, b;
  bool double_sided = false;
};

// Where the triangles cross the plane p[axis] = offset: one segment a triangle that has corners on both sides. A corner in the
// plane counts as above it, so that a closed surface gives closed lines; a triangle that lies in the plane gives none.
std::vector<CutSegment> cutTriangles(const std::vector<ViewTriangle>& triangles, int axis, double offset);

// Whether the segment meets the triangle, border and ends included, by Möller & Trumbore (1997). False when it runs parallel.
bool meetsTriangle(const glm::dvec3& a, const glm::dvec3& b, const ViewTriangle& triangle);

// Whether the triangle's bounding box and its plane meet the box: false only when the triangle does not.
bool mayMeetBox(const ViewTriangle& triangle, const glm::dvec3& low, const glm::dvec3& high);

}  // namespace nlg
