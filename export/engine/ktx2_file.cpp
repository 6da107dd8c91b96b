#include "export/engine/ktx2_file.h"

#include <bit>
#include <vector>

#include "export/engine/little_endian.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr std::string_view kIdentifier("\xabKTX 20\xbb\r\n\x1a\n", 12);
constexpr size_t kWord = sizeof(uint32_t), kHeaderBytes = 12 + 9 * kWord + 4 * kWord + 16, kLevelBytes = 24;

// One sample of the data format descriptor (Khronos Data Format 1.3, basic descriptor block).
struct Sample {
  uint32_t first_bit, bits, channel, lower, upper;
};
constexpr uint32_t kRed = 0, kGreen = 1, kBlue = 2, kAlpha = 15;
constexpr uint32_t kExponent = 0x20, kSigned = 0x40, kFloat = 0x80;

std::vector<Sample> samplesOf(Ktx2Format format) {
  std::vector<Sample> samples;
  if (format == Ktx2Format::rgba16f) {
    for (const uint32_t channel : {kRed, kGreen, kBlue, kAlpha}) {
      samples.push_back({static_cast<uint32_t>(16 * samples.size()), 16, channel | kSigned | kFloat,
                         std::bit_cast<uint32_t>(-1.0f), std::bit_cast<uint32_t>(1.0f)});
    }
    return samples;
  }
  // a mantissa and the exponent that all share, channel by channel; 8448 and 31 are those of the largest power of two
  for (const uint32_t channel : {kRed, kGreen, kBlue}) {
    samples.push_back({9 * channel, 9, channel, 0, 8448});
    samples.push_back({27, 5, channel | kExponent, 15, 31});
  }
  return samples;
}

std::string dataFormatDescriptor(Ktx2Format format) {
  constexpr uint32_t kBlockBytes = 24, kSampleBytes = 16, kVersion = 2, kColorModelRgb = 1, kPrimariesBt709 = 1,
                     kTransferLinear = 1;
  const std::vector<Sample> samples = samplesOf(format);
  const size_t block = kBlockBytes + kSampleBytes * samples.size();
  std::string bytes;
  appendNumber(kWord + block, kWord, &bytes);
  appendNumber(0, kWord, &bytes);  // vendor and type: Khronos, basic
  appendNumber(kVersion, 2, &bytes);
  appendNumber(block, 2, &bytes);
  for (const uint32_t byte : {kColorModelRgb, kPrimariesBt709, kTransferLinear, 0u}) appendNumber(byte, 1, &bytes);
  appendNumber(0, kWord, &bytes);  // a block is one texel
  appendNumber(texelBytes(format), 8, &bytes);
  for (const Sample& sample : samples) {
    appendNumber(sample.first_bit, 2, &bytes);
    appendNumber(sample.bits - 1, 1, &bytes);
    appendNumber(sample.channel, 1, &bytes);
    appendNumber(0, kWord, &bytes);  // position
    appendNumber(sample.lower, kWord, &bytes);
    appendNumber(sample.upper, kWord, &bytes);
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

std::map<std::string, std::string> textsOf(const std::string& name, std::string_view bytes) {
  std::map<std::string, std::string> texts;
  while (!bytes.empty()) {
    const size_t length = bytes.size() < kWord ? bytes.size() : numberAt(bytes, 0, kWord);
    const size_t key_end = length > 0 && length <= bytes.size() - kWord ? bytes.find('\0', kWord) : std::string_view::npos;
    if (key_end == std::string_view::npos || key_end >= kWord + length)
      throw InputError(name, "key and value data", "keys that end with a zero byte", "others");
    std::string_view value = bytes.substr(key_end + 1, kWord + length - key_end - 1);
    if (!value.empty() && value.back() == '\0') value.remove_suffix(1);
    texts[std::string(bytes.substr(kWord, key_end - kWord))] = value;
    bytes.remove_prefix(std::min(bytes.size(), kWord + (length + kWord - 1) / kWord * kWord));
  }
  return texts;
}

}  // namespace

size_t texelBytes(Ktx2Format format) { return format == Ktx2Format::rgba16f ? 8 : 4; }

std::string ktx2Bytes(const Ktx2Texture& texture) {
  const size_t texel = texelBytes(texture.format);
  NLG_CHECK(texture.texels.size(), ==, texel * texelsOf(texture.size));
  const std::string descriptor = dataFormatDescriptor(texture.format), texts = keyValueData(texture.texts);
  const size_t descriptor_place = kHeaderBytes + kLevelBytes, texts_place = descriptor_place + descriptor.size();
  const size_t texels_place = (texts_place + texts.size() + texel - 1) / texel * texel;
  std::string bytes(kIdentifier);
  const uint32_t type_size = texture.format == Ktx2Format::rgba16f ? 2 : 4;
  for (const uint32_t number :
       {static_cast<uint32_t>(texture.format), type_size, texture.size[0], texture.size[1], texture.size[2],
        0u /* layers: no array */, 1u /* faces */, 1u /* levels */, 0u /* supercompression */})
    appendNumber(number, kWord, &bytes);
  for (const size_t number : {descriptor_place, descriptor.size(), texts.empty() ? 0 : texts_place, texts.size()})
    appendNumber(number, kWord, &bytes);
  for (int i = 0; i < 2; ++i) appendNumber(0, 8, &bytes);  // supercompression's data
  for (const size_t number : {texels_place, texture.texels.size(), texture.texels.size()}) appendNumber(number, 8, &bytes);
  bytes += descriptor + texts;
  pad(texel, &bytes);
  return bytes + texture.texels;
}

Ktx2Texture parseKtx2(const std::string& name, std::string_view bytes) {
  if (bytes.size() < kHeaderBytes + kLevelBytes || bytes.substr(0, kIdentifier.size()) != kIdentifier)
    throw InputError(name, "its beginning", "the header of a KTX 2.0 file", std::to_string(bytes.size()) + " other bytes");
  const auto word = [&](size_t i) { return static_cast<uint32_t>(numberAt(bytes, kIdentifier.size() + i * kWord, kWord)); };
  Ktx2Texture texture;
  texture.format = static_cast<Ktx2Format>(word(0));
  if (texture.format != Ktx2Format::rgba16f && texture.format != Ktx2Format::rgb9e5)
    throw InputError(name, "vkFormat", "97 or 123", std::to_string(word(0)));
  texture.size = {word(2), word(3), word(4)};
  for (const auto& [place, expected] : {std::pair<size_t, uint32_t>{5, 0}, {6, 1}, {7, 1}, {8, 0}}) {
    if (word(place) != expected)
      throw InputError(name, "word " + std::to_string(place) + " of the header", std::to_string(expected),
                       std::to_string(word(place)));
  }
  const uint64_t place = numberAt(bytes, kHeaderBytes, 8), count = numberAt(bytes, kHeaderBytes + 8, 8);
  for (const uint32_t side : texture.size) {
    if (side == 0 || side > kMaxTextureSide) throw InputError(name, "size", "sides of 1 to 2048 texels", std::to_string(side));
  }
  if (count != texelBytes(texture.format) * texelsOf(texture.size) || place > bytes.size() || count > bytes.size() - place)
    throw InputError(name, "level 0", "bytes of the file, as many as the size says", std::to_string(count));
  texture.texels = bytes.substr(place, count);
  const size_t texts_place = word(11), texts_bytes = word(12);
  if (texts_place > bytes.size() || texts_bytes > bytes.size() - texts_place)
    throw InputError(name, "key and value data", "bytes of the file", std::to_string(texts_bytes));
  texture.texts = textsOf(name, bytes.substr(texts_place, texts_bytes));
  return texture;
}

}  // namespace nlg
