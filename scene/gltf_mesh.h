// One mesh of a glTF file as triangles in its own coordinates.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <tiny_gltf.h>
#include <glm/glm.hpp>

#include "scene/gltf_looks.h"
#include "scene/scene_budget.h"

namespace nlg {

// Only vertices that triangles use; flat triangles are still there.
struct GltfMesh {
  std::vector<glm::vec3> positions;  // finite
  std::vector<glm::uvec3> triangles;
  std::vector<uint32_t> triangle_material;  // the file's, or as many as it has for "none"
  // One for each position, or none where the looks have no such images, and no primitive such colours (scene.h).
  std::vector<glm::vec2> base_places, emissive_places;
  std::vector<glm::vec4> colours;
  uint32_t unplaced_count = 0;  // primitives with an image, and without all of their places on it: (0, 0) instead
};

// Triangles, strips and fans of all primitives; points and lines are skipped.
//
// mesh_idx   within the model's meshes; looks: the model's; path: the file's name, for errors
// budgets    its triangles and the elements of accessors are taken from them
// throws     InputError naming mesh, primitive and attribute on whatever does not fit together, and on what the budgets do not hold
GltfMesh readGltfMesh(const tinygltf::Model& model, int mesh_idx, const GltfLooks& looks, const std::string& path,
                      SceneBudgets& budgets);

}  // namespace nlg
