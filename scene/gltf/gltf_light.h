// Reads the lights of a glTF file (KHR_lights_punctual).
#pragma once

#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "scene/model/oddities.h"
#include "scene/model/scene_light.h"

namespace tinygltf {
class Model;
class Node;
class Value;
}  // namespace tinygltf

namespace nlg {

// Stands at its node's origin and points along the node's -z; scale does not change it. `range` is left aside: light does not end.
struct GltfLight {
  LightLabel label;          // its name; the group that its extras say
  bool is_left_out = false;  // too odd to shine
  bool is_sun = false;       // "directional"
  bool is_spot = false;
  double intensity = 1.0;    // as the file has it
  glm::vec3 strength{0.0f};  // colour times intensity: cd of a lamp, lux of a sun
  float cos_inner = -1.0f, cos_outer = -1.0f;
};

// All lights that the file declares. Odd ones are mended where what was meant is plain: cones are brought to
// 0 <= inner < outer <= pi / 2, and colours above 1 stay as they are. A light is left out whose type is unknown, whose colour or intensity is negative, whose cone is empty, whose strength is above 1e12, or in which something is no number.
//
// odd      receives these
std::vector<GltfLight> readGltfLights(const std::string& path, const tinygltf::Model& model, Oddities* odd);

// Which of them a node carries; -1: none.
// throws   InputError naming the place on an index that is not below light_count
int lightOfNode(const std::string& path, const std::string& place, const tinygltf::Node& node, size_t light_count);

// The text at kLightGroupKey of something's extras; empty without one.
inline constexpr const char* kLightGroupKey = "light_group";
std::string lightGroupOf(const tinygltf::Value& extras);

// Whether a file says that Blender's exporter wrote it.
bool isOfBlender(const tinygltf::Model& model);

// The unit of a file's lights, by the program that wrote it (docs/theory/light.md, Units); of an unknown one: same, without a sign. The
// exporter of Blender 3.3 and before knew one unit alone, raw. Of later ones watts tell, which are whole or have few digits in the unit
// that was theirs; and where they have not, it is the exporter's default, standard, unless lamps and suns would be too faint in it.
LightUnit unitOfLights(const tinygltf::Model& model, const std::vector<GltfLight>& lights);
// Of the suns of which Blender 5.0 to 5.1.0 lost the strength, and of the lamps' colours: a line, or nothing.
std::string noteOfLostSuns(const tinygltf::Model& model, const std::vector<GltfLight>& lights);

// A lamp of that size; its position is for the caller to set.
inline constexpr float kGltfLampRadius_m = 0.05f;
Lamp lampOf(const GltfLight& light, const glm::dvec3& direction);
Sun sunOf(const GltfLight& light, const glm::dvec3& direction);

}  // namespace nlg
