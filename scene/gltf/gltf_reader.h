// Reads a level from glTF 2.0, text (.gltf) or binary (.glb), through tinygltf.
#pragma once

#include <string>
#include <vector>

#include "scene/image/image_loader.h"
#include "scene/model/scene.h"
#include "scene/solid/transmissive.h"

namespace nlg {

struct GltfLevel {
  Scene scene;
  std::vector<std::string> notes;  // what the file holds that was not read, or read otherwise; a line each
};

// What of a file is read.
struct GltfChoice {
  std::string scene_name;              // the scene's name, or its number from 1 on; empty: the default scene
  std::vector<std::string> leave_out;  // nodes, with all that hangs on them, by patterns of their names
};

// The default scene; the first one if none is named; all root nodes if there is none. What no eye sees is left out (gltf_nodes.h), and
// noted with what other scenes hold.
//
// Geometry   Every node's mesh under its transform, evaluated in double; instances are copied. A negative determinant turns the
//            winding. One SceneObject for each node with a mesh, of EXT_mesh_gpu_instancing for each instance. Triangles of zero area are
//            dropped and counted. Morph targets at the weights that the file gives them, skins where it has their joints.
// Primitives Triangles, strips and fans, indexed with 8, 16 or 32 bits or not at all. Points and lines are skipped.
// Accessors  Positions in floats, or in integers of 8 and 16 bits (KHR_mesh_quantization); any stride; sparse ones too. Buffer views
//            packed by EXT_ or KHR_meshopt_compression, primitives by KHR_draco_mesh_compression (gltf_packed.h).
// Materials  Base colour, doubleSided, emission times KHR_materials_emissive_strength in cd/m², alpha and KHR_materials_transmission
//            (transmissive.h), with their images: PNG, JPEG, WebP (image_decode.h), in the file, in buffers, or in its folder or
//            below; and COLOR_0. An image that cannot be read is noted (gltf_looks.h).
// Light      KHR_lights_punctual (gltf_light.h), in cd and lux; a lamp is a sphere of 5 cm radius. A file has no sky.
// Cameras    Perspective ones become viewpoints; orthographic ones are skipped.
//
// path     the file; its external buffers must lie in its folder or below
// unit_m   metres of one unit of the file, finite, above 0: 1, when it keeps to the rule. Intensities of lamps stay what they are
// dense_transmissive   as judgeTransmissive has it; need: of images
// returns  the scene; its id is the file's stem
// notes    one part that is broken is left out or mended, and noted: an index or accessor out of range, numbers that are not finite,
//          positions beyond 1e9 m, a node that is its own ancestor, a value of a wrong JSON type (gltf_json.h)
// throws   InputError naming file, place ("mesh 3, primitive 0: POSITION"), expected and got, on
//          - a missing, truncated or malformed file; one of which nothing is left
//          - more than the budgets hold (scene_file.h)
//          - a buffer's URI that leaves the folder: with "..", absolute, or of a scheme other than data:
//          - a required extension that may change where triangles are and is not read, by its name
//          UsageError on a scene_name that no scene has
GltfLevel readGltf(const std::string& path, double unit_m = 1.0, double dense_transmissive = kDenseTransmissive,
                   const GltfChoice& choice = {}, ImageNeed need = ImageNeed::all);

}  // namespace nlg
