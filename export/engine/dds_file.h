// DDS files of one 3-D texture of RGBA16F, with the header of Direct3D 10 (learn.microsoft.com: "Programming guide for DDS").
#pragma once

#include <string>
#include <string_view>

#include "export/engine/texture_3d.h"

namespace nlg {

// size     of one texel or more
// texels   8 bytes each, x is the fastest index, z the slowest
std::string ddsBytes(const TextureSize& size, std::string_view texels);

struct DdsTexture {
  TextureSize size{};
  std::string texels;
};

// name     of the file, for errors
// throws   InputError where the bytes are none that ddsBytes gives
DdsTexture parseDds(const std::string& name, std::string_view bytes);

}  // namespace nlg
