// Reads one mesh of a glTF file as triangles in its own coordinates.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <tiny_gltf.h>
#include <glm/glm.hpp>

#include "scene/archive/scene_file.h"
#include "scene/gltf/gltf_looks.h"
#include "scene/model/oddities.h"

namespace nlg {

// Only vertices that triangles use; flat triangles are still there.
struct GltfMesh {
  std::vector<glm::vec3> positions;  // finite
  std::vector<glm::uvec3> triangles;
  std::vector<uint32_t> triangle_material;  // the file's, or as many as it has for "none"
  // One for each position, or none where the looks have no such images, and no primitive such colours (scene.h).
  std::vector<glm::vec2> base_places, emissive_places;
  std::vector<glm::vec4> colours;
  bool is_mirrored = false;     // by its joints: what winds one way winds the other
  uint32_t unplaced_count = 0;  // primitives with an image, and without all of their places on it: (0, 0) instead
};

// How a file has a node's mesh stand.
struct GltfPose {
  std::vector<double> weights;     // of morph targets; those that are not said are 0
  std::vector<glm::dmat4> joints;  // of its skin: where each joint takes what is bound to it; none: it has no skin
};

// Triangles, strips and fans of all primitives; points and lines are skipped, and primitives left out in which something does not fit
// together.
//
// mesh_idx   within the model's meshes; looks: the model's; path: the file's name, for errors
// budgets    its triangles and the elements of accessors are taken from them
// odd        receives mesh, primitive and attribute of these
// throws     BudgetError naming mesh, primitive and attribute on what the budgets do not hold
GltfMesh readGltfMesh(const tinygltf::Model& model, int mesh_idx, const GltfLooks& looks, const GltfPose& pose,
                      const std::string& path, SceneBudgets& budgets, Oddities* odd);

}  // namespace nlg
