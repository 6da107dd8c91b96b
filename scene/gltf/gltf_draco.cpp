// https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Khronos/KHR_draco_mesh_compression
// The stream's beginning: https://google.github.io/draco/spec
#include "scene/gltf/gltf_packed.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <new>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>
#include <tiny_gltf.h>

#include "scene/gltf/gltf_accessor.h"
#include "tool/error.h"

namespace nlg {
namespace {

// A regular surface takes about a bit a face, and has half a point a face, of at most 64 bytes of attributes: 256 for a byte. No
// more memory is taken for a stream than for one eight, and four, times as dense, whatever it promises.
constexpr uint64_t kMostFacesPerByte = 64;
constexpr uint64_t kMostAttributeBytesPerByte = 1024;
constexpr uint64_t kStoredBytes = 12;  // of a face and of a point: three indices, three floats

using Stream = std::span<const unsigned char>;

// What the stream's beginning says.
struct StreamStart {
  uint64_t face_count = 0;
  bool is_edgebreaker = false;
};

// A decoder that stops between the description of the attributes and their values, for which it would take memory at once.
template <class Decoder>
class BoundedDecoder : public Decoder {
 public:
  explicit BoundedDecoder(uint64_t most_bytes) : most_bytes_(most_bytes) {}
  uint64_t attributeBytes() const { return bytes_; }

 protected:
  bool DecodeAllAttributes() override {
    const draco::PointCloud& points = *this->point_cloud();
    for (int i = 0; i < points.num_attributes(); ++i) {
      const draco::PointAttribute& attribute = *points.attribute(i);
      const int value_bytes = attribute.num_components() * draco::DataTypeLength(attribute.data_type());
      bytes_ += uint64_t{points.num_points()} * static_cast<uint64_t>(value_bytes);
    }
    return bytes_ <= most_bytes_ && Decoder::DecodeAllAttributes();
  }

 private:
  uint64_t most_bytes_, bytes_ = 0;
};

class DracoPrimitive {
 public:
  DracoPrimitive(const std::string& path, const std::string& place, tinygltf::Model& model, tinygltf::Primitive& primitive)
      : path_(path), place_(place + ": " + kDraco), model_(model), primitive_(primitive) {}

  void unpack(SceneBudget& faces_left, SceneBudget& bytes_left) {
    const tinygltf::Value& extension = primitive_.extensions.at(kDraco);
    if (primitive_.mode != TINYGLTF_MODE_TRIANGLES) fail("mode 4, triangles", std::to_string(primitive_.mode));
    const int view = index(extension, "bufferView");
    const int position_id = extension.Has("attributes") ? index(extension.Get("attributes"), "POSITION") : -1;
    if (position_id < 0) fail("attributes with a POSITION", "none");
    const Stream stream = bytesOfView(model_, view, path_, place_);
    const StreamStart start = startOf(stream);
    if (start.face_count / kMostFacesPerByte > stream.size())
      fail("at most 64 faces for each of " + std::to_string(stream.size()) + " bytes", std::to_string(start.face_count));
    faces_left.take(start.face_count, path_, place_);
    draco::Mesh mesh;
    if (start.is_edgebreaker) {
      decode<draco::MeshEdgebreakerDecoder>(stream, bytes_left, &mesh);
    } else {
      decode<draco::MeshSequentialDecoder>(stream, bytes_left, &mesh);
    }
    bytes_left.take(kStoredBytes * (uint64_t{mesh.num_faces()} + mesh.num_points()), path_, place_);
    storePositions(mesh, position_id);
    storeLooks(mesh, extension.Get("attributes"));
    storeIndices(mesh);
  }

 private:
  [[noreturn]] void fail(const std::string& expected, const std::string& got) const {
    throw InputError(path_, place_, expected, got);
  }

  // Kinds and ranges the text has been checked for.
  static int index(const tinygltf::Value& object, const char* key) {
    return object.Has(key) && object.Get(key).IsInt() ? object.Get(key).Get<int>() : -1;
  }

  // For the faces that the stream's beginning promises its decoder reserves memory at once.
  StreamStart startOf(const Stream& stream) const {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
    draco::DracoHeader header;
    const bool is_draco = draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok();
    if (!is_draco || header.encoder_type != draco::TRIANGULAR_MESH) fail("a Draco mesh", "other bytes");
    const std::string version = std::to_string(header.version_major) + "." + std::to_string(header.version_minor);
    if (version != "2.2") fail("version 2.2 of Draco's bit stream", version);
    buffer.set_bitstream_version(DRACO_BITSTREAM_VERSION(header.version_major, header.version_minor));
    bool is_read = true;
    if ((header.flags & METADATA_FLAG_MASK) != 0) {
      draco::GeometryMetadata metadata;
      is_read = draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &metadata);
    }
    uint32_t vertices = 0, faces = 0;
    const bool is_edgebreaker = header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING;
    if (!is_edgebreaker && header.encoder_method != draco::MESH_SEQUENTIAL_ENCODING)
      fail("one of Draco's two encodings of meshes", std::to_string(header.encoder_method));
    if (is_edgebreaker) {
      uint8_t traversal = 0;
      is_read = is_read && buffer.Decode(&traversal) && draco::DecodeVarint(&vertices, &buffer);
    }
    if (!is_read || !draco::DecodeVarint(&faces, &buffer)) fail("a Draco mesh", "a truncated or damaged header");
    return {faces, is_edgebreaker};
  }

  template <class Decoder>
  void decode(const Stream& stream, SceneBudget& bytes_left, draco::Mesh* mesh) const {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
    const uint64_t most_bytes = std::min(bytes_left.left(), kMostAttributeBytesPerByte * stream.size());
    BoundedDecoder<Decoder> decoder(most_bytes);
    try {
      const draco::Status status = decoder.Decode(draco::DecoderOptions(), &buffer, mesh);
      if (status.ok()) return bytes_left.take(decoder.attributeBytes(), path_, place_);
      if (decoder.attributeBytes() > most_bytes)
        fail("attributes of at most " + std::to_string(most_bytes) + " bytes", std::to_string(decoder.attributeBytes()));
      const std::string words = status.error_msg_string();
      fail("a Draco mesh", words.empty() ? "bytes that do not unpack" : words.substr(0, 80));
    } catch (const std::bad_alloc&) {
      fail("a Draco mesh", "a mesh that takes more memory than there is");
    } catch (const std::length_error&) {
      fail("a Draco mesh", "a mesh that takes more memory than there is");
    }
  }

  void storePositions(const draco::Mesh& mesh, int unique_id) {
    const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(static_cast<uint32_t>(unique_id));
    if (attribute == nullptr) fail("an attribute of the number of POSITION", std::to_string(unique_id));
    if (attribute->data_type() != draco::DT_FLOAT32 || attribute->num_components() != 3)
      fail("positions of three floats", std::to_string(attribute->num_components()) + " components of Draco's type " +
                                            std::to_string(static_cast<int>(attribute->data_type())));
    store("POSITION", mesh, *attribute, TINYGLTF_COMPONENT_TYPE_FLOAT, false);
  }

  // Places on images, colours and joints, by whatever numbers; those that the stream does not have the primitive has not, either.
  void storeLooks(const draco::Mesh& mesh, const tinygltf::Value& ids) {
    for (auto entry = primitive_.attributes.begin(); entry != primitive_.attributes.end();) {
      const auto& [name, accessor_idx] = *entry;
      const bool is_look =
          name.starts_with("TEXCOORD_") || name == "COLOR_0" || name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_");
      const int id = is_look ? index(ids, name.c_str()) : -1;
      const draco::PointAttribute* attribute = id < 0 ? nullptr : mesh.GetAttributeByUniqueId(static_cast<uint32_t>(id));
      const int type = attribute == nullptr ? -1 : componentType(attribute->data_type());
      const bool is_known = type >= 0 && attribute->num_components() >= 2 && attribute->num_components() <= 4;
      if (is_known) store(name, mesh, *attribute, type, isNormalized(accessor_idx));
      entry = is_look && !is_known ? primitive_.attributes.erase(entry) : std::next(entry);
    }
  }

  static int componentType(draco::DataType type) {
    constexpr std::pair<draco::DataType, int> kTypes[] = {{draco::DT_INT8, TINYGLTF_COMPONENT_TYPE_BYTE},
                                                          {draco::DT_UINT8, TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE},
                                                          {draco::DT_INT16, TINYGLTF_COMPONENT_TYPE_SHORT},
                                                          {draco::DT_UINT16, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT},
                                                          {draco::DT_FLOAT32, TINYGLTF_COMPONENT_TYPE_FLOAT}};
    const auto known = std::find_if(std::begin(kTypes), std::end(kTypes), [&](const auto& of) { return of.first == type; });
    return known == std::end(kTypes) ? -1 : known->second;
  }

  bool isNormalized(int accessor_idx) const {
    const bool is_there = accessor_idx >= 0 && static_cast<size_t>(accessor_idx) < model_.accessors.size();
    return is_there && model_.accessors[static_cast<size_t>(accessor_idx)].normalized;
  }

  // The attribute's own bytes, point by point, as the primitive's attribute of that name.
  void store(const std::string& name, const draco::Mesh& mesh, const draco::PointAttribute& attribute, int component_type,
             bool is_normalized) {
    const auto value_bytes =
        static_cast<size_t>(attribute.num_components()) * static_cast<size_t>(draco::DataTypeLength(attribute.data_type()));
    std::vector<unsigned char> bytes(mesh.num_points() * value_bytes);
    for (uint32_t i = 0; i < mesh.num_points(); ++i) {
      const draco::AttributeValueIndex value = attribute.mapped_index(draco::PointIndex(i));
      // unpacking does not check that
      const bool is_there = value.value() < attribute.size() && attribute.byte_stride() == static_cast<int64_t>(value_bytes) &&
                            static_cast<size_t>(attribute.GetBytePos(value)) + value_bytes <= attribute.buffer()->data_size();
      if (!is_there) fail("a " + name + " of every point", "none of point " + std::to_string(i));
      attribute.GetValue(value, bytes.data() + i * value_bytes);
    }
    const int types[] = {TINYGLTF_TYPE_VEC2, TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC4};
    const int accessor = addAccessor(std::move(bytes), component_type, types[attribute.num_components() - 2], mesh.num_points());
    model_.accessors[static_cast<size_t>(accessor)].normalized = is_normalized;
    primitive_.attributes[name] = accessor;
  }

  void storeIndices(const draco::Mesh& mesh) {
    std::vector<unsigned char> bytes(size_t{mesh.num_faces()} * 3 * sizeof(uint32_t));
    for (uint32_t i = 0; i < mesh.num_faces(); ++i) {
      const draco::Mesh::Face& face = mesh.face(draco::FaceIndex(i));
      const std::array<uint32_t, 3> corners = {face[0].value(), face[1].value(), face[2].value()};
      std::memcpy(bytes.data() + i * sizeof corners, corners.data(), sizeof corners);
    }
    primitive_.indices =
        addAccessor(std::move(bytes), TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR, size_t{mesh.num_faces()} * 3);
  }

  // An accessor that is the whole of a new buffer.
  int addAccessor(std::vector<unsigned char> bytes, int component_type, int type, size_t count) {
    tinygltf::BufferView view;
    view.buffer = static_cast<int>(model_.buffers.size());
    view.byteLength = bytes.size();
    tinygltf::Accessor accessor;
    accessor.bufferView = static_cast<int>(model_.bufferViews.size());
    accessor.componentType = component_type;
    accessor.type = type;
    accessor.count = count;
    model_.buffers.emplace_back();
    model_.buffers.back().data = std::move(bytes);
    model_.bufferViews.push_back(std::move(view));
    model_.accessors.push_back(std::move(accessor));
    return static_cast<int>(model_.accessors.size()) - 1;
  }

  const std::string& path_;
  const std::string place_;
  tinygltf::Model& model_;
  tinygltf::Primitive& primitive_;
};

}  // namespace

void unpackDraco(const std::string& path, tinygltf::Model& model, SceneBudget& bytes_left, Oddities* odd) {
  SceneBudget faces_left = SceneBudgets().triangles;
  for (size_t i = 0; i < model.meshes.size(); ++i) {
    std::vector<tinygltf::Primitive>& primitives = model.meshes[i].primitives;
    for (size_t k = 0; k < primitives.size(); ++k) {
      if (primitives[k].extensions.count(kDraco) == 0) continue;
      const std::string place = "mesh " + std::to_string(i) + ", primitive " + std::to_string(k);
      if (!odd->attempt("left out", [&] { DracoPrimitive(path, place, model, primitives[k]).unpack(faces_left, bytes_left); }))
        primitives[k].attributes.clear();
    }
  }
}

}  // namespace nlg
