// Lights of a glTF file: the extension KHR_lights_punctual.
#pragma once

#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "scene/scene_light.h"

namespace tinygltf {
class Model;
class Node;
}  // namespace tinygltf

namespace nlg {

// Stands at its node's origin and points along the node's -z; scale does not change it. `range` is left aside: light does not end.
struct GltfLight {
  bool is_sun = false;  // "directional"
  bool is_spot = false;
  glm::vec3 strength{0.0f};  // colour times intensity: cd of a lamp, lux of a sun
  float cos_inner = -1.0f, cos_outer = -1.0f;
};

// All lights that the file declares.
// throws   InputError naming the light on an unknown type, a colour that is no three numbers from 0 to 1, an intensity that is no
//          number from 0 to 1e12, cone angles other than 0 <= inner < outer <= pi / 2
std::vector<GltfLight> readGltfLights(const std::string& path, const tinygltf::Model& model);

// Which of them a node carries; -1: none.
// throws   InputError naming the place on an index that is not below light_count
int lightOfNode(const std::string& path, const std::string& place, const tinygltf::Node& node, size_t light_count);

// A lamp of that size; its position is for the caller to set.
inline constexpr float kGltfLampRadius_m = 0.05f;
Lamp lampOf(const GltfLight& light, const glm::dvec3& direction);
Sun sunOf(const GltfLight& light, const glm::dvec3& direction);

}  // namespace nlg
