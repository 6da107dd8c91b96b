// EXT_meshopt_compression: https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Vendor/EXT_meshopt_compression
#include "scene/gltf_meshopt.h"

#include <cstdint>
#include <utility>
#include <vector>

#include <meshoptimizer.h>
#include <tiny_gltf.h>

#include "tool/error.h"

namespace nlg {
namespace {

constexpr const char* kMeshopt = "EXT_meshopt_compression";
// Of vertices, 16 bytes take a quarter of a byte or more; a triangle's 12 bytes take one or more, an index's 4 one or more.
constexpr uint64_t kBestRatio = 64;

// What the extension says of one buffer view.
struct PackedView {
  uint64_t buffer = 0, offset = 0, byte_count = 0;  // the packed bytes
  uint64_t stride = 0, count = 0;                   // of unpacked elements
  std::string mode, filter;
};

class MeshoptView {
 public:
  // buffer_count   of the file; those behind are of views that have been unpacked
  MeshoptView(const std::string& path, const tinygltf::Model& model, size_t view_idx, size_t buffer_count)
      : path_(path),
        model_(model),
        buffer_count_(buffer_count),
        view_(model.bufferViews[view_idx]),
        place_("buffer view " + std::to_string(view_idx) + ": " + kMeshopt),
        packed_(readExtension(view_.extensions.at(kMeshopt))) {}

  std::vector<unsigned char> unpack(SceneBudget& bytes_left) const {
    const unsigned char* bytes = packedBytes();
    checkElements();
    const uint64_t size = packed_.count * packed_.stride;  // both below 2^31
    if (size != view_.byteLength) fail("count times byteStride as the view's byteLength", std::to_string(size));
    if (size / kBestRatio > packed_.byte_count)
      fail("at most 64 bytes for each of " + std::to_string(packed_.byte_count) + " packed ones", std::to_string(size));
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
    if (packed_.filter != "EXPONENTIAL")
      fail("the filter NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL", packed_.filter.substr(0, 40));
  }

  int decode(const unsigned char* bytes, unsigned char* unpacked) const {
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
  }

  const std::string& path_;
  const tinygltf::Model& model_;
  const size_t buffer_count_;
  const tinygltf::BufferView& view_;
  const std::string place_;
  const PackedView packed_;
};

}  // namespace

void unpackMeshopt(const std::string& path, tinygltf::Model& model, SceneBudget& bytes_left) {
  const size_t buffer_count = model.buffers.size();
  for (size_t i = 0; i < model.bufferViews.size(); ++i) {
    if (model.bufferViews[i].extensions.count(kMeshopt) == 0) continue;
    tinygltf::Buffer buffer;
    buffer.data = MeshoptView(path, model, i, buffer_count).unpack(bytes_left);
    model.bufferViews[i].buffer = static_cast<int>(model.buffers.size());
    model.bufferViews[i].byteOffset = 0;
    model.buffers.push_back(std::move(buffer));
  }
}

}  // namespace nlg
