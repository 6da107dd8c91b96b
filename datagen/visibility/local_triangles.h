// The triangles that touch a support, in its local coordinates and prepared for segment tests.
//
// Everything is computed in double from the scene's positions and the probe's, then rounded once: a probe 100 km from the origin,
// or a triangle a thousand spacings wide, loses nothing. Triangles that share corners get the same bits for them.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "runtime_eval/simd/aligned.h"
#include "scene/model/scene.h"

namespace nlg {

// How far, in local units, a triangle reaches beyond its edges in its own plane: closes the cracks that rounding would leave
// between neighbours. 2^-20 of a spacing, a micrometre at a metre.
inline constexpr float kEdgeReach = 0x1p-20f;
// Distance at which a box counts as clear of a triangle: above every rounding error of the segment tests plus kEdgeReach.
inline constexpr float kBoxMargin = 0x1p-17f;

// One triangle: the point x lies in it when normal · x = offset and, for its three edges, outward_e · x <= reach_e, and x is in
// its box. Vectors are of unit length; coordinates of the box are clipped to [-4, 4].
struct LocalTriangle {
  float normal[3];
  float offset;
  float outward[3][3];  // edge, axis: in the triangle's plane, away from it
  float reach[3];       // kEdgeReach included
  float center[3], extent[3];
};

// Appends the triangles among `candidates` that touch the cube [-1, 1]³ around the probe, or come within kBoxMargin of it, to
// `triangles`; triangles without area in local coordinates are left out.
// position_m   relative to the scene's origin; spacing_m > 0
void collectLocalTriangles(const std::vector<glm::vec3>& positions, const std::vector<glm::uvec3>& scene_triangles,
                           const std::vector<uint32_t>& candidates, const glm::dvec3& position_m, double spacing_m,
                           std::vector<LocalTriangle>* triangles);

}  // namespace nlg
