// Decodes Draco meshes of a glTF file (KHR_draco_mesh_compression).
#pragma once

#include <string>

#include "scene/archive/scene_file.h"
#include "scene/model/oddities.h"

namespace tinygltf {
class Model;
}

namespace nlg {

// Gives every primitive that is packed by Draco indices, positions, places on images and colours of its own, as plain buffers hold
// them; other attributes are left aside. What is unpacked may be as damaged as any other file's: nothing is said of its numbers.
//
// model    of plain_text (gltf_json.h), without the primitives' indices
// odd      receives, naming mesh and primitive, what cannot be unpacked, and then has no attributes: a missing or wrong buffer view or attribute, a mode other than triangles, a
//          Draco stream other than a mesh of version 2.2, more than 64 faces or 1 KiB of attributes for one packed byte,
//          bytes that do not unpack
// throws   BudgetError on more triangles in all than one scene may have, and more bytes than the budget holds
void unpackDraco(const std::string& path, tinygltf::Model& model, SceneBudget& bytes_left, Oddities* odd);

}  // namespace nlg
