#include "export/engine/dds_file.h"

#include "export/engine/little_endian.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr size_t kWord = sizeof(uint32_t), kTexelBytes = 8, kHeaderBytes = 4 + 124 + 20;

std::string headerOf(const TextureSize& size) {
  constexpr uint32_t kHasCaps = 1, kHasHeight = 2, kHasWidth = 4, kHasPitch = 8, kHasPixelFormat = 0x1000, kHasDepth = 0x800000;
  constexpr uint32_t kFourLetters = 4, kTexture = 0x1000, kComplex = 8, kVolume = 0x200000;
  constexpr uint32_t kRgba16f = 10, kTexture3d = 4;  // DXGI_FORMAT_R16G16B16A16_FLOAT, D3D10_RESOURCE_DIMENSION_TEXTURE3D
  std::string bytes = "DDS ";
  const auto append = [&](std::initializer_list<uint32_t> words) {
    for (const uint32_t word : words) appendNumber(word, kWord, &bytes);
  };
  append({124, kHasCaps | kHasHeight | kHasWidth | kHasPitch | kHasPixelFormat | kHasDepth, size[1], size[0],
          static_cast<uint32_t>(size[0] * kTexelBytes), size[2], 1});
  bytes.append(11 * kWord, '\0');
  append({32, kFourLetters});
  bytes += "DX10";
  bytes.append(5 * kWord, '\0');  // bits of formats without a number
  append({kTexture | kComplex, kVolume, 0, 0, 0});
  append({kRgba16f, kTexture3d, 0, 1, 0});
  return bytes;
}

}  // namespace

std::string ddsBytes(const TextureSize& size, std::string_view texels) {
  NLG_CHECK(texels.size(), ==, kTexelBytes * texelsOf(size));
  return headerOf(size).append(texels);
}

DdsTexture parseDds(const std::string& name, std::string_view bytes) {
  if (bytes.size() < kHeaderBytes)
    throw InputError(name, "its beginning", "the header of a DDS file", std::to_string(bytes.size()) + " bytes");
  const auto word = [&](size_t i) { return static_cast<uint32_t>(numberAt(bytes, i * kWord, kWord)); };
  DdsTexture texture;
  texture.size = {word(4), word(3), word(6)};
  if (bytes.substr(0, kHeaderBytes) != headerOf(texture.size))
    throw InputError(name, "header", "that of a 3-D texture of RGBA16F without mipmaps", "another");
  for (const uint32_t side : texture.size) {
    if (side == 0 || side > kMaxTextureSide) throw InputError(name, "size", "sides of 1 to 2048 texels", std::to_string(side));
  }
  texture.texels = bytes.substr(kHeaderBytes);
  if (texture.texels.size() != kTexelBytes * texelsOf(texture.size))
    throw InputError(name, "texels", std::to_string(kTexelBytes * texelsOf(texture.size)) + " bytes",
                     std::to_string(texture.texels.size()));
  return texture;
}

}  // namespace nlg
