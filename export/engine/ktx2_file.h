// KTX 2.0 files of one 3-D texture of RGBA16F: one level, no supercompression (registry.khronos.org/KTX/specs/2.0).
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "export/engine/texture_3d.h"

namespace nlg {

// size     of one texel or more
// texels   8 bytes each; x is the fastest index, z the slowest
// texts    by key; those that begin with KTX are the format's own
std::string ktx2Bytes(const TextureSize& size, std::string_view texels, const std::map<std::string, std::string>& texts);

}  // namespace nlg
