// Buffer views packed by EXT_meshopt_compression, made plain: tinygltf leaves them packed.
//
// Such a view names packed bytes elsewhere; where it lies itself (a "fallback" buffer) need not exist (gltf_json.h).
#pragma once

#include <string>

#include "scene/scene_budget.h"

namespace tinygltf {
class Model;
}

namespace nlg {

// Unpacks every packed buffer view into a buffer of its own, which the view then is the whole of. What is unpacked may be as
// damaged as any other file's: nothing is said of its numbers.
//
// throws    InputError naming the buffer view on a range outside its buffer, an unknown mode or filter, a stride that they do not
//           allow, a length other than count times stride, more than 64 bytes for one packed byte (no encoder reaches that),
//           more in all than the budget holds, bytes that do not unpack
void unpackMeshopt(const std::string& path, tinygltf::Model& model, SceneBudget& bytes_left);

}  // namespace nlg
