// Unpacks what a glTF file holds packed: buffer views of EXT_meshopt_compression and KHR_meshopt_compression, and Draco meshes
// (KHR_draco_mesh_compression). What is unpacked may be as damaged as any other file's: nothing is said of its numbers.
#pragma once

#include <string>

#include "scene/archive/scene_file.h"
#include "scene/model/oddities.h"

namespace tinygltf {
class Model;
}

namespace nlg {

inline constexpr const char* kDraco = "KHR_draco_mesh_compression";

// Unpacks every packed buffer view, which tinygltf leaves packed, into a buffer of its own, which the view then is the whole of.
// Such a view names packed bytes elsewhere; where it lies itself (a "fallback" buffer) need not exist (gltf_json.h).
//
// odd       receives, naming the buffer view, what cannot be unpacked, and then stays where it lies: a range outside its buffer,
//           an unknown mode or filter, a stride that they do not allow, a length other than count times stride, more bytes for
//           one packed byte than any encoder reaches (64; 1,024 of version 1), bytes that do not unpack
// throws    BudgetError on more in all than the budget holds
void unpackMeshopt(const std::string& path, tinygltf::Model& model, SceneBudget& bytes_left, Oddities* odd);

// Gives every primitive that is packed by Draco indices, positions, places on images and colours of its own, as plain buffers
// hold them; other attributes are left aside.
//
// model    of plain_text (gltf_json.h), without the primitives' indices
// odd      receives, naming mesh and primitive, what cannot be unpacked, and then has no attributes: a missing or wrong buffer
//          view or attribute, a mode other than triangles, a Draco stream other than a mesh of version 2.2, more than 64 faces or
//          1 KiB of attributes for one packed byte, bytes that do not unpack
// throws   BudgetError on more triangles in all than one scene may have, and more bytes than the budget holds
void unpackDraco(const std::string& path, tinygltf::Model& model, SceneBudget& bytes_left, Oddities* odd);

}  // namespace nlg
