// The square of gltf_parts.h, packed by the libraries' own encoders.
#pragma once

#include "tests/scene/gltf/gltf_parts.h"

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <draco/metadata/geometry_metadata.h>
#include <meshoptimizer.h>

namespace nlg {

inline std::string packedVertices(const std::string& vertices, size_t stride) {
  const size_t count = vertices.size() / stride;
  std::string packed(meshopt_encodeVertexBufferBound(count, stride), '\0');
  auto* bytes = reinterpret_cast<unsigned char*>(packed.data());
  packed.resize(meshopt_encodeVertexBuffer(bytes, packed.size(), vertices.data(), count, stride));
  return packed;
}

using Encode = size_t (*)(unsigned char*, size_t, const unsigned int*, size_t);

inline std::string packedIndices(const std::vector<unsigned>& indices, Encode encode, size_t bound) {
  std::string packed(bound, '\0');
  packed.resize(encode(reinterpret_cast<unsigned char*>(packed.data()), bound, indices.data(), indices.size()));
  return packed;
}

// The square of Parts, its views packed by EXT_meshopt_compression; they lie in buffer 1, which does not exist.
inline Parts meshoptSquare(const std::string& index_mode = "TRIANGLES") {
  const std::vector<unsigned> corners = {0, 1, 2, 0, 2, 3};
  const std::string positions = packedVertices(kSquare.substr(0, 48), 12);
  const std::string indices = index_mode == "TRIANGLES"
                                  ? packedIndices(corners, meshopt_encodeIndexBuffer, meshopt_encodeIndexBufferBound(6, 4))
                                  : packedIndices(corners, meshopt_encodeIndexSequence, meshopt_encodeIndexSequenceBound(6, 4));
  Parts parts;
  parts.bin = positions + indices;
  const auto extension = [](size_t offset, size_t length, const std::string& rest) {
    return R"("extensions":{"EXT_meshopt_compression":{"buffer":0,"byteOffset":)" + std::to_string(offset) + R"(,"byteLength":)" +
           std::to_string(length) + "," + rest + "}}}";
  };
  parts.views = R"([{"buffer":1,"byteLength":48,"byteStride":12,)" +
                extension(0, positions.size(), R"("byteStride":12,"count":4,"mode":"ATTRIBUTES")") +
                R"(,{"buffer":1,"byteOffset":48,"byteLength":12,)" +
                extension(positions.size(), indices.size(), R"("byteStride":2,"count":6,"mode":")" + index_mode + "\"") + "]";
  parts.more_buffers = R"(,{"byteLength":60,"extensions":{"EXT_meshopt_compression":{"fallback":true}}})";
  parts.more = R"(,"extensionsUsed":["EXT_meshopt_compression"],"extensionsRequired":["EXT_meshopt_compression"])";
  return parts;
}

using Corners = std::vector<glm::vec3>;
using Faces = std::vector<std::array<uint32_t, 3>>;

// A Draco stream; POSITION is attribute 0.
inline std::string dracoStream(const Corners& corners, const Faces& faces, draco::MeshEncoderMethod method,
                               draco::DataType type = draco::DT_FLOAT32, bool has_metadata = false) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(static_cast<int>(faces.size()));
  const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, type);
  for (size_t f = 0; f < faces.size(); ++f) {
    const auto set = [&](const auto& values) {
      builder.SetAttributeValuesForFace(position, draco::FaceIndex(static_cast<uint32_t>(f)), &values[0], &values[1], &values[2]);
    };
    std::array<glm::vec3, 3> floats;
    std::array<glm::ivec3, 3> integers;
    for (int k = 0; k < 3; ++k) floats[k] = corners[faces[f][k]], integers[k] = glm::ivec3(corners[faces[f][k]]);
    if (type == draco::DT_FLOAT32) {
      set(floats);
    } else {
      set(integers);
    }
  }
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  if (has_metadata) {
    auto metadata = std::make_unique<draco::GeometryMetadata>();
    metadata->AddEntryString("made by", "a test");
    mesh->AddMetadata(std::move(metadata));
  }
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 14);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
  return {buffer.data(), buffer.size()};
}

inline std::string dracoSquare(draco::MeshEncoderMethod method, draco::DataType type = draco::DT_FLOAT32,
                               bool has_metadata = false) {
  return dracoStream({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}, method, type, has_metadata);
}

// A file whose accessors have no buffer views: the stream alone holds the square.
inline Parts dracoParts(const std::string& stream) {
  Parts parts;
  parts.bin = stream;
  parts.views = R"([{"buffer":0,"byteLength":)" + std::to_string(stream.size()) + "}]";
  parts.accessors = R"([{"componentType":5126,"count":4,"type":"VEC3"},{"componentType":5123,"count":6,"type":"SCALAR"}])";
  parts.primitives =
      R"([{"attributes":{"POSITION":0},"indices":1,"extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{"POSITION":0}}}}])";
  parts.more = R"(,"extensionsUsed":["KHR_draco_mesh_compression"],"extensionsRequired":["KHR_draco_mesh_compression"])";
  return parts;
}

}  // namespace nlg
