#include "export/engine/engine_format.h"

#include <bit>
#include <map>

#include <nlohmann/json.hpp>

#include "tool/error.h"

namespace nlg {
namespace {

// KTX 2.0 files of one 3-D texture of RGBA16F: one level, no supercompression (registry.khronos.org/KTX/specs/2.0).

constexpr std::string_view kIdentifier("\xabKTX 20\xbb\r\n\x1a\n", 12);
constexpr size_t kWord = sizeof(uint32_t), kHeaderBytes = 12 + 9 * kWord + 4 * kWord + 16, kLevelBytes = 24, kTexelBytes = 8;

// Khronos Data Format 1.3: one basic descriptor block, of a sample a channel.
std::string dataFormatDescriptor() {
  constexpr uint32_t kBlockBytes = 24, kSampleBytes = 16, kVersion = 2, kColorModelRgb = 1, kPrimariesBt709 = 1,
                     kTransferLinear = 1, kSigned = 0x40, kFloat = 0x80;
  constexpr uint32_t kSampleChannels[] = {0, 1, 2, 15};  // red, green, blue, alpha
  constexpr size_t kBlock = kBlockBytes + kSampleBytes * std::size(kSampleChannels);
  std::string bytes;
  appendNumber(kWord + kBlock, kWord, &bytes);
  appendNumber(0, kWord, &bytes);  // vendor and type: Khronos, basic
  appendNumber(kVersion, 2, &bytes);
  appendNumber(kBlock, 2, &bytes);
  for (const uint32_t byte : {kColorModelRgb, kPrimariesBt709, kTransferLinear, 0u}) appendNumber(byte, 1, &bytes);
  appendNumber(0, kWord, &bytes);  // a block is one texel
  appendNumber(kTexelBytes, 8, &bytes);
  for (size_t i = 0; i < std::size(kSampleChannels); ++i) {
    appendNumber(16 * i, 2, &bytes);
    appendNumber(16 - 1, 1, &bytes);
    appendNumber(kSampleChannels[i] | kSigned | kFloat, 1, &bytes);
    appendNumber(0, kWord, &bytes);  // position
    appendNumber(std::bit_cast<uint32_t>(-1.0f), kWord, &bytes);
    appendNumber(std::bit_cast<uint32_t>(1.0f), kWord, &bytes);
  }
  return bytes;
}

void pad(size_t alignment, std::string* bytes) { bytes->resize((bytes->size() + alignment - 1) / alignment * alignment, '\0'); }

// Sorted by key, as the map is; values end with a zero byte, as texts must.
std::string keyValueData(const std::map<std::string, std::string>& texts) {
  std::string bytes;
  for (const auto& [key, value] : texts) {
    appendNumber(key.size() + value.size() + 2, kWord, &bytes);
    bytes.append(key).push_back('\0');
    bytes.append(value).push_back('\0');
    pad(kWord, &bytes);
  }
  return bytes;
}

// size     of one texel or more
// texels   8 bytes each; x is the fastest index, z the slowest
// texts    by key; those that begin with KTX are the format's own
std::string ktx2Bytes(const TextureSize& size, std::string_view texels, const std::map<std::string, std::string>& texts) {
  NLG_CHECK(texels.size(), ==, kTexelBytes * texelsOf(size));
  constexpr uint32_t kRgba16f = 97, kTypeSize = 2;  // VK_FORMAT_R16G16B16A16_SFLOAT
  const std::string descriptor = dataFormatDescriptor(), key_values = keyValueData(texts);
  const size_t descriptor_place = kHeaderBytes + kLevelBytes, texts_place = descriptor_place + descriptor.size();
  const size_t texels_place = (texts_place + key_values.size() + kTexelBytes - 1) / kTexelBytes * kTexelBytes;
  std::string bytes(kIdentifier);
  for (const uint32_t number : {kRgba16f, kTypeSize, size[0], size[1], size[2], 0u /* layers: no array */, 1u /* faces */,
                                1u /* levels */, 0u /* supercompression */})
    appendNumber(number, kWord, &bytes);
  for (const size_t number : {descriptor_place, descriptor.size(), key_values.empty() ? 0 : texts_place, key_values.size()})
    appendNumber(number, kWord, &bytes);
  for (int i = 0; i < 2; ++i) appendNumber(0, 8, &bytes);  // supercompression's data
  for (const size_t number : {texels_place, texels.size(), texels.size()}) appendNumber(number, 8, &bytes);
  bytes += descriptor + key_values;
  pad(kTexelBytes, &bytes);
  return bytes.append(texels);
}

EngineFile threeFile(const LightBox& /*box*/, const std::string& texels) { return {"light.bin", texels}; }

EngineIrradiance threeIrradiance(Texture3d texture, const LightBox& box) {
  return [texture = std::move(texture), box](const PositionM& position_m, const float* normal_3) {
    PositionM moved_m;
    for (size_t axis = 0; axis < 3; ++axis) {
      const double texel_m = (box.high_m[axis] - box.low_m[axis]) / box.texel_count[axis], margin_m = 0.01 * texel_m;
      moved_m[axis] = position_m[axis] + 0.5 * texel_m * normal_3[axis];
      if (!(moved_m[axis] >= box.low_m[axis] - margin_m && moved_m[axis] <= box.high_m[axis] + margin_m))
        return std::array<float, kShChannels>{};
    }
    const std::array<float, kShFloats> light = shTextureLight(texture, box, moved_m);
    std::array<float, kShChannels> rgb = shIrradiance(light.data(), normal_3[0], normal_3[1], normal_3[2]);
    for (float& channel : rgb) channel = std::max(0.0f, channel);  // three.js has no floor
    return rgb;
  };
}

template <class Three>
std::string spaced(const Three& three) {
  std::string text;
  for (const auto& number : three) text += (text.empty() ? "" : " ") + nlohmann::json(number).dump();
  return text;
}

EngineFile ktx2File(const LightBox& box, const std::string& texels) {
  return {"light.ktx2", ktx2Bytes(shTextureSize(box.texel_count), texels,
                                  {{"KTXwriter", "nlg-export engine"},
                                   {"nlg.low_m", spaced(box.low_m)},
                                   {"nlg.high_m", spaced(box.high_m)},
                                   {"nlg.resolution", spaced(box.texel_count)}})};
}

EngineIrradiance pixelIrradiance(Texture3d texture, const LightBox& box) {
  return [texture = std::move(texture), box](const PositionM& position_m, const float* normal_3) {
    return flooredIrradiance(shTextureLight(texture, box, position_m).data(), normal_3[0], normal_3[1], normal_3[2]);
  };
}

}  // namespace

const std::vector<TextureFormat>& textureFormats() {
  static const std::vector<TextureFormat> formats = {{"three", 0.5, threeFile, threeIrradiance},
                                                     {"ktx2-sh", 0.0, ktx2File, pixelIrradiance}};
  return formats;
}

const TextureFormat* findTexture(const std::string& name) {
  for (const TextureFormat& format : textureFormats()) {
    if (format.name == name) return &format;
  }
  return nullptr;
}

std::string textureNames() {
  std::string names;
  for (const TextureFormat& format : textureFormats()) names += std::string(format.name) + ", ";
  return names;
}

}  // namespace nlg
