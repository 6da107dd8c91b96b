// KTX 2.0 files of one 3-D texture: one level, no supercompression (registry.khronos.org/KTX/specs/2.0).
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "export/engine/texture_3d.h"

namespace nlg {

// By their numbers in Vulkan.
enum class Ktx2Format : uint32_t { rgba16f = 97, rgb9e5 = 123 };

// Bytes of a texel: 8 or 4.
size_t texelBytes(Ktx2Format format);

struct Ktx2Texture {
  Ktx2Format format = Ktx2Format::rgba16f;
  TextureSize size{};
  std::string texels;                        // x is the fastest index, z the slowest
  std::map<std::string, std::string> texts;  // by key; those that begin with KTX are the format's own
};

// texture   of one texel or more, as many bytes as its size says
std::string ktx2Bytes(const Ktx2Texture& texture);

// What ktx2Bytes gives, and what else has one level, no supercompression and one of the two formats.
// name     of the file, for errors
// throws   InputError where the bytes are none of that
Ktx2Texture parseKtx2(const std::string& name, std::string_view bytes);

}  // namespace nlg
