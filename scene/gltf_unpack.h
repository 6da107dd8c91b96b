// Compressed parts of a glTF file, made plain: tinygltf refuses them or leaves them packed.
//
// EXT_meshopt_compression: a buffer view names packed bytes elsewhere; where it lies itself (a "fallback" buffer) need not exist.
// KHR_draco_mesh_compression: gltf_draco.h.
#pragma once

#include <string>
#include <string_view>

#include "scene/scene_budget.h"

namespace tinygltf {
class Model;
}

namespace nlg {

// The file's text as tinygltf takes it, before it is loaded: fallback buffers without a URI hold one byte, and primitives packed
// by Draco have no indices, whose accessors need no buffer view.
//
// text      as checkGltfText has passed it
// throws    InputError where the JSON library refuses it
std::string plainGltfText(const std::string& path, std::string_view text);

// Unpacks every packed buffer view into a buffer of its own, which the view then is the whole of. What is unpacked may be as
// damaged as any other file's: nothing is said of its numbers.
//
// throws    InputError naming the buffer view on a range outside its buffer, an unknown mode or filter, a stride that they do not
//           allow, a length other than count times stride, more than 64 bytes for one packed byte (no encoder reaches that),
//           more in all than the budget holds, bytes that do not unpack
void unpackMeshopt(const std::string& path, tinygltf::Model& model, SceneBudget& bytes_left);

}  // namespace nlg
