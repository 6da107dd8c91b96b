// https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Khronos/KHR_meshopt_compression and Vendor/EXT_meshopt_compression
#include "scene/gltf/gltf_packed.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include <meshoptimizer.h>
#include <tiny_gltf.h>

#include "scene/gltf/gltf_json.h"
#include "tool/error.h"

namespace nlg {
namespace {

// Of vertices, 16 bytes take a quarter of a byte or more; a triangle's 12 bytes take one or more, an index's 4 one or more.
// Version 1 has blocks of up to 256 elements of which 4 bytes take one.
constexpr uint64_t kBestRatio = 64, kBestRatio1 = 1024;
constexpr unsigned char kVersion1 = 0xa1;

// What the extension says of one buffer view.
struct PackedView {
  uint64_t buffer = 0, offset = 0, byte_count = 0;  // the packed bytes
  uint64_t stride = 0, count = 0;                   // of unpacked elements
  std::string mode, filter;
};

// Version 1 of the codec of attributes, which KHR_meshopt_compression brought and the library's 0.18 does not know: its appendix A.
class AttributesCodec1 {
 public:
  AttributesCodec1(const unsigned char* bytes, size_t byte_count, size_t stride)
      : at_(bytes + 1), end_(bytes + byte_count), stride_(stride) {}

  // returns   false on bytes that are too few, too many, or of a channel that is not known
  bool decode(size_t count, unsigned char* unpacked) {
    const size_t tail = stride_ + stride_ / 4, padded_tail = std::max<size_t>(tail, 24);
    if (static_cast<size_t>(end_ - at_) < padded_tail) return false;
    const unsigned char* channels = end_ - stride_ / 4;
    previous_.assign(end_ - tail, channels);
    end_ -= padded_tail;
    const size_t most = std::min<size_t>((8192 / stride_) & ~size_t{15}, 256);
    for (size_t first = 0, in_block = 0; first < count; first += in_block) {
      in_block = std::min(most, count - first);
      const unsigned char* controls = take(stride_ / 4);
      for (size_t k = 0; k < stride_; ++k) {
        if (controls == nullptr || !decodeByte(controls[k / 4] >> (2 * (k % 4)) & 3, in_block, &deltas_[k % 4])) return false;
        const int mode = channels[k / 4] & 15, turn = channels[k / 4] >> 4;
        if (mode > 2 || (mode < 2 && turn > 0)) return false;
        unsigned char* out = unpacked + first * stride_ + k - k % 4;
        if (k % 4 == 3 && mode == 0) add<uint8_t>(out, in_block, k - 3, 0);
        if (k % 4 == 3 && mode == 1) add<uint16_t>(out, in_block, k - 3, 0);
        if (k % 4 == 3 && mode == 2) add<uint32_t>(out, in_block, k - 3, turn);
      }
    }
    return at_ == end_;
  }

 private:
  const unsigned char* take(size_t byte_count) {
    return static_cast<size_t>(end_ - at_) < byte_count ? nullptr : std::exchange(at_, at_ + byte_count);
  }

  // One byte of each element of a block.
  bool decodeByte(int control, size_t count, std::array<unsigned char, 256>* deltas) {
    constexpr std::array<std::array<int, 4>, 2> kBits = {{{0, 1, 2, 4}, {1, 2, 4, 8}}};
    deltas->fill(0);
    if (control == 2) return true;
    const unsigned char* bytes = take(control == 3 ? count : (count + 63) / 64);
    if (bytes == nullptr) return false;
    if (control == 3) std::copy_n(bytes, count, deltas->begin());
    for (size_t group = 0; control < 2 && 16 * group < count; ++group) {
      if (!decodeGroup(kBits[control][bytes[group / 4] >> (2 * (group % 4)) & 3], deltas->data() + 16 * group)) return false;
    }
    return true;
  }

  // Sixteen of them. All bits set stand for a byte that follows behind the group.
  bool decodeGroup(int bits, unsigned char* deltas) {
    const unsigned char* packed = take(2 * static_cast<size_t>(bits));
    for (int i = 0; packed != nullptr && bits > 0 && i < 16; ++i) {
      const int bit = i * bits, shift = bits == 1 ? bit % 8 : 8 - bits - bit % 8, all = (1 << bits) - 1;
      deltas[i] = static_cast<unsigned char>(packed[bit / 8] >> shift & all);
      if (bits == 8 || deltas[i] != all) continue;
      const unsigned char* byte = take(1);
      if (byte == nullptr) return false;
      deltas[i] = *byte;
    }
    return packed != nullptr;
  }

  // Four bytes of each element: one number or several, each by its difference from the element's before.
  template <class Number>
  void add(unsigned char* out, size_t count, size_t k, int turn) {
    for (size_t part = 0; part < 4; part += sizeof(Number)) {
      Number value = 0;
      std::memcpy(&value, &previous_[k + part], sizeof value);
      for (size_t i = 0; i < count; ++i) {
        Number delta = 0;
        for (size_t b = sizeof(Number); b > 0; --b) delta = static_cast<Number>(uint64_t{delta} << 8 | deltas_[part + b - 1][i]);
        const auto unfolded = static_cast<Number>((delta & 1) != 0 ? ~(delta >> 1) : delta >> 1);
        value = static_cast<Number>(sizeof(Number) == 4 ? value ^ std::rotr(delta, turn) : value + unfolded);
        std::memcpy(out + i * stride_ + part, &value, sizeof value);
      }
      std::memcpy(&previous_[k + part], &value, sizeof value);
    }
  }

  const unsigned char *at_, *end_;
  const size_t stride_;
  std::vector<unsigned char> previous_;  // element
  std::array<std::array<unsigned char, 256>, 4> deltas_{};
};

// The filter COLOR, of KHR_meshopt_compression alone: its appendix B.
template <class Unsigned>
void decodeColours(unsigned char* bytes, uint64_t count) {
  for (uint64_t i = 0; i < count; ++i, bytes += 4 * sizeof(Unsigned)) {
    std::array<Unsigned, 4> in;
    std::memcpy(in.data(), bytes, sizeof in);
    using Signed = std::make_signed_t<Unsigned>;
    const int whole = std::max((1 << std::bit_width(in[3])) - 1, 1), alpha = in[3] & whole >> 1;
    const int y = in[0], co = static_cast<Signed>(in[1]), cg = static_cast<Signed>(in[2]);
    const std::array<int, 4> rgba = {y + co - cg, y + cg, y - co - cg, alpha << 1 | (alpha & 1)};
    constexpr float kMost = std::numeric_limits<Unsigned>::max();
    for (size_t c = 0; c < 4; ++c) {
      const float code = std::round(static_cast<float>(rgba[c]) * (kMost / static_cast<float>(whole)));
      in[c] = static_cast<Unsigned>(std::clamp(code, 0.0f, kMost));
    }
    std::memcpy(bytes, in.data(), sizeof in);
  }
}

class MeshoptView {
 public:
  // extension      of the two; buffer_count: of the file; those behind are of views that have been unpacked
  MeshoptView(const std::string& path, const tinygltf::Model& model, size_t view_idx, const char* extension, size_t buffer_count)
      : path_(path),
        model_(model),
        buffer_count_(buffer_count),
        view_(model.bufferViews[view_idx]),
        place_("buffer view " + std::to_string(view_idx) + ": " + extension),
        packed_(readExtension(view_.extensions.at(extension))) {}

  std::vector<unsigned char> unpack(SceneBudget& bytes_left) const {
    const unsigned char* bytes = packedBytes();
    checkElements();
    const uint64_t size = packed_.count * packed_.stride;  // both below 2^31
    if (size != view_.byteLength) fail("count times byteStride as the view's byteLength", std::to_string(size));
    const uint64_t ratio = isVersion1(bytes) ? kBestRatio1 : kBestRatio;
    if (size / ratio > packed_.byte_count)
      fail("at most " + std::to_string(ratio) + " bytes for each of " + std::to_string(packed_.byte_count) + " packed ones",
           std::to_string(size));
    bytes_left.take(size, path_, place_);
    std::vector<unsigned char> unpacked(size);
    const int status = decode(bytes, unpacked.data());
    if (status != 0) fail("packed " + packed_.mode, "bytes that do not unpack (" + std::to_string(status) + ")");
    applyFilter(unpacked.data());
    return unpacked;
  }

 private:
  [[noreturn]] void fail(const std::string& expected, const std::string& got) const {
    throw InputError(path_, place_, expected, got);
  }

  // Numbers' kinds and ranges the text has been checked for.
  uint64_t number(const tinygltf::Value& extension, const char* key) const {
    const double value = extension.Has(key) ? extension.Get(key).GetNumberAsDouble() : -1.0;
    if (!(value >= 0.0)) fail(key, "none");
    return static_cast<uint64_t>(value);
  }

  static std::string text(const tinygltf::Value& extension, const char* key, const char* otherwise) {
    return extension.Has(key) && extension.Get(key).IsString() ? extension.Get(key).Get<std::string>() : otherwise;
  }

  PackedView readExtension(const tinygltf::Value& extension) const {
    if (!extension.IsObject()) fail("an object", "another value");
    PackedView packed;
    packed.buffer = number(extension, "buffer");
    packed.offset = extension.Has("byteOffset") ? number(extension, "byteOffset") : 0;
    packed.byte_count = number(extension, "byteLength");
    packed.stride = number(extension, "byteStride");
    packed.count = number(extension, "count");
    packed.mode = text(extension, "mode", "none");
    packed.filter = text(extension, "filter", "NONE");
    return packed;
  }

  const unsigned char* packedBytes() const {
    if (packed_.buffer >= buffer_count_) fail("a buffer below " + std::to_string(buffer_count_), std::to_string(packed_.buffer));
    const std::vector<unsigned char>& data = model_.buffers[packed_.buffer].data;
    if (packed_.offset > data.size() || packed_.byte_count > data.size() - packed_.offset) {
      fail("packed bytes within the buffer's " + std::to_string(data.size()),
           std::to_string(packed_.byte_count) + " at " + std::to_string(packed_.offset));
    }
    return data.data() + packed_.offset;
  }

  bool isVersion1(const unsigned char* bytes) const {
    return packed_.mode == "ATTRIBUTES" && packed_.byte_count > 0 && bytes[0] == kVersion1;
  }

  // What the decoders take for granted.
  void checkElements() const {
    const uint64_t stride = packed_.stride;
    const auto require = [&](bool holds, const std::string& expected) {
      if (!holds) fail(expected, std::to_string(stride));
    };
    const bool is_attributes = packed_.mode == "ATTRIBUTES";
    if (is_attributes) {
      require(stride >= 4 && stride <= 256 && stride % 4 == 0, "a byteStride of 4 to 256, a multiple of 4");
    } else if (packed_.mode == "TRIANGLES" || packed_.mode == "INDICES") {
      require(stride == 2 || stride == 4, "a byteStride of 2 or 4");
      if (packed_.mode == "TRIANGLES" && packed_.count % 3 != 0)
        fail("a count that is a multiple of 3", std::to_string(packed_.count));
    } else {
      fail("the mode ATTRIBUTES, TRIANGLES or INDICES", packed_.mode.substr(0, 40));
    }
    if (packed_.filter == "NONE") return;
    if (!is_attributes) fail("no filter of indices", packed_.filter.substr(0, 40));
    if (packed_.filter == "OCTAHEDRAL") return require(stride == 4 || stride == 8, "a byteStride of 4 or 8");
    if (packed_.filter == "QUATERNION") return require(stride == 8, "a byteStride of 8");
    if (packed_.filter == "COLOR") return require(stride == 4 || stride == 8, "a byteStride of 4 or 8");
    if (packed_.filter != "EXPONENTIAL")
      fail("the filter NONE, OCTAHEDRAL, QUATERNION, EXPONENTIAL or COLOR", packed_.filter.substr(0, 40));
  }

  int decode(const unsigned char* bytes, unsigned char* unpacked) const {
    if (isVersion1(bytes))
      return AttributesCodec1(bytes, packed_.byte_count, packed_.stride).decode(packed_.count, unpacked) ? 0 : -1;
    if (packed_.mode == "ATTRIBUTES")
      return meshopt_decodeVertexBuffer(unpacked, packed_.count, packed_.stride, bytes, packed_.byte_count);
    if (packed_.mode == "TRIANGLES")
      return meshopt_decodeIndexBuffer(unpacked, packed_.count, packed_.stride, bytes, packed_.byte_count);
    return meshopt_decodeIndexSequence(unpacked, packed_.count, packed_.stride, bytes, packed_.byte_count);
  }

  void applyFilter(unsigned char* unpacked) const {
    if (packed_.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(unpacked, packed_.count, packed_.stride);
    if (packed_.filter == "QUATERNION") meshopt_decodeFilterQuat(unpacked, packed_.count, packed_.stride);
    if (packed_.filter == "EXPONENTIAL") meshopt_decodeFilterExp(unpacked, packed_.count, packed_.stride);
    if (packed_.filter == "COLOR" && packed_.stride == 4) decodeColours<uint8_t>(unpacked, packed_.count);
    if (packed_.filter == "COLOR" && packed_.stride == 8) decodeColours<uint16_t>(unpacked, packed_.count);
  }

  const std::string& path_;
  const tinygltf::Model& model_;
  const size_t buffer_count_;
  const tinygltf::BufferView& view_;
  const std::string place_;
  const PackedView packed_;
};

}  // namespace

void unpackMeshopt(const std::string& path, tinygltf::Model& model, SceneBudget& bytes_left, Oddities* odd) {
  const size_t buffer_count = model.buffers.size();
  for (size_t i = 0; i < model.bufferViews.size(); ++i) {
    for (const char* extension : kMeshoptExtensions) {
      if (model.bufferViews[i].extensions.count(extension) == 0) continue;
      tinygltf::Buffer buffer;
      const auto unpack = [&] { buffer.data = MeshoptView(path, model, i, extension, buffer_count).unpack(bytes_left); };
      if (!odd->attempt("its plain copy instead; where there is none, left out", unpack)) break;
      model.bufferViews[i].buffer = static_cast<int>(model.buffers.size());
      model.bufferViews[i].byteOffset = 0;
      model.buffers.push_back(std::move(buffer));
      break;
    }
  }
}

}  // namespace nlg
