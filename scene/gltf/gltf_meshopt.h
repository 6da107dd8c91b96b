// Decodes buffer views packed by EXT_meshopt_compression or KHR_meshopt_compression, which tinygltf leaves packed.
//
// Such a view names packed bytes elsewhere; where it lies itself (a "fallback" buffer) need not exist (gltf_json.h).
#pragma once

#include <string>

#include "scene/archive/scene_file.h"
#include "scene/model/oddities.h"

namespace tinygltf {
class Model;
}

namespace nlg {

// Unpacks every packed buffer view into a buffer of its own, which the view then is the whole of. What is unpacked may be as
// damaged as any other file's: nothing is said of its numbers.
//
// odd       receives, naming the buffer view, what cannot be unpacked, and then stays where it lies: a range outside its buffer, an
//           unknown mode or filter, a stride that they do not allow, a length other than count times stride, more bytes for one packed
//           byte than any encoder reaches (64; 1,024 of version 1), bytes that do not unpack
// throws    BudgetError on more in all than the budget holds
void unpackMeshopt(const std::string& path, tinygltf::Model& model, SceneBudget& bytes_left, Oddities* odd);

}  // namespace nlg
