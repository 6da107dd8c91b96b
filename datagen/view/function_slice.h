// Samples one plane through a weighting function at every pixel, without interpolating through walls.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "nlg/support.h"
#include "scene/scene.h"

namespace nlg {

// A scene's triangle in the coordinates of a picture.
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

// How an axis plane lies in its picture: x, y, z of the plane point right, up or down. Top views look down: z points down.
struct PlaneView {
  int normal = 2, right = 0, up = 1;
  double up_sign = 1.0;  // -1: the axis `up` points down

  // Picture coordinates in [-1, 1]², y down, of local coordinates, and back.
  glm::dvec2 fromLocal(const glm::dvec3& local) const { return {local[right], -up_sign * local[up]}; }
  glm::dvec3 toLocal(const glm::dvec2& picture) const;
};

// normal   0, 1 or 2: the planes yz, zx and xy
PlaneView planeView(int normal);

enum class PixelKind : uint8_t {
  unknown,   // no support point within reach is visible from here
  solid,     // the function is invalid here
  seen,      // the probe sees this place
  diffused,  // it does not: whatever stands here came round a corner
};

struct FunctionSlice {
  PlaneView plane;
  int size = 0;
  std::vector<PixelKind> kind;    // size x size, from the upper left
  std::vector<float> phi;         // in [0, 1]; 0 where kind is unknown or solid
  std::vector<float> seen_share;  // of the weight of valid points: the border of what is seen lies at 1/2
};

// The slice through the probe.
//
// With triangles: every pixel takes the support points within kSliceReach that it sees past them, with a weight that falls to 0
// at the reach. The points vote on the kind; the value is that of a plane fitted to the points of the winning kind, not below the
// lowest of them (0 stays 0, and nothing else becomes 0) and not above 1. Nothing is carried through a surface. Without (null):
// every pixel takes its nearest support point.
//
// triangles   those near the probe, in local coordinates
FunctionSlice makeFunctionSlice(const StoredFunction& function, int normal, int size, const std::vector<ViewTriangle>* triangles);

inline constexpr double kSliceReach = 0.2;  // shares of the spacing; the points stand 0.1 apart

// The normal of the plane in which the function differs most from the bare tent, summed over the points near it. A plane of which less than
// a quarter is air counts for less.
int mostTellingPlane(const StoredFunction& function);

}  // namespace nlg
