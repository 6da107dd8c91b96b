// Triangulates a curved patch: a grid of biquadratic Bézier surfaces of Quake III levels.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace nlg {

struct PatchMesh {
  std::vector<glm::dvec3> positions;
  std::vector<std::vector<glm::dvec3>> carried;  // in the order of the arguments, one value for each position
  std::vector<glm::uvec3> triangles;             // none names a vertex twice
};

// Every curve of three control points is cut into 1, 2, 4 … 32 segments: the fewest whose chords leave the curve by no more than
// tolerance (32 where that is not enough). The number depends on the size of the curve alone, not on the view.
// An edge depends on its own control points only, in either order, bit for bit: two patches, or a patch and what was built onto
// it, whose control points agree along an edge have the same vertices along it.
//
// control     width x height points, row by row; both odd and >= 3
// tolerance   in the unit of control; > 0
// carried     what else the control points hold, each as long as control: curved over the patch as the positions are
// returns     triangles that are counter-clockwise where columns are counted to the right and rows upward
PatchMesh tessellatePatch(const std::vector<glm::dvec3>& control, uint32_t width, uint32_t height, double tolerance,
                          const std::vector<std::vector<glm::dvec3>>& carried = {});

// The most triangles that such a patch can have.
uint64_t maxPatchTriangles(uint32_t width, uint32_t height);

}  // namespace nlg
