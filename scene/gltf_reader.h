// Reads a level from glTF 2.0, text (.gltf) or binary (.glb), through tinygltf.
#pragma once

#include <string>

#include "scene/scene.h"

namespace nlg {

// The triangles of the default scene (the first one if none is named; all root nodes if there is none): every node's mesh under
// its transform, evaluated in double; instances are copied; a negative determinant turns the winding. Primitives: triangles,
// strips and fans, indexed with 8, 16 or 32 bits or not at all; points and lines are skipped. Accessors: float positions,
// or integers of 8 and 16 bits (KHR_mesh_quantization), any stride, sparse ones too; buffer views packed by
// EXT_meshopt_compression (gltf_meshopt.h), primitives by KHR_draco_mesh_compression (gltf_draco.h). Materials: base colour factor,
// emissive factor (times KHR_materials_emissive_strength), doubleSided. One SceneObject for each node with a mesh. Triangles of zero area are dropped and counted.
// Light: KHR_lights_punctual (gltf_light.h), in cd and lux, emission in cd/m²; a lamp is a sphere of 5 cm radius. A file has no sky.
// Perspective cameras become viewpoints; orthographic ones are skipped.
// Skins and morph targets stay in their rest pose; textures and images are never opened.
//
// path     the file; its external buffers must lie in its folder or below
// unit_m   metres of one unit of the file, finite, above 0: 1, when it keeps to the rule. Intensities of lamps stay what they are
// returns  the scene; its id is the file's stem
// throws   InputError naming file, place ("mesh 3, primitive 0: POSITION"), expected and got, on: a missing, truncated or
//          malformed file, an index or accessor out of range, non-finite numbers, a buffer URI that leaves the folder (".." , absolute,
//          scheme other than data:), a node that is its own ancestor, nesting deeper than 256, more than the
//          budgets hold (scene_budget.h), positions beyond 1e9 m, a value of a wrong JSON type, a required extension other than
//          these three and those of materials, textures and lights, by its name
Scene readGltf(const std::string& path, double unit_m = 1.0);

}  // namespace nlg
