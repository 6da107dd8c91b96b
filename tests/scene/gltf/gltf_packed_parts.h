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

// The square in a Draco stream; POSITION is attribute 0.
//
// has_looks   each corner has its x and y as its place on images, attribute 1, and as red and green of its colour, attribute 2
inline std::string dracoSquare(draco::MeshEncoderMethod method, bool has_metadata = false, bool has_looks = false) {
  constexpr std::array<std::array<float, 3>, 4> kCorners = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}};
  constexpr uint32_t kFaces[2][3] = {{0, 1, 2}, {0, 2, 3}};
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(2);
  const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int place = has_looks ? builder.AddAttribute(draco::GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32) : -1;
  const int colour = has_looks ? builder.AddAttribute(draco::GeometryAttribute::COLOR, 4, draco::DT_UINT8) : -1;
  for (uint32_t f = 0; f < 2; ++f) {
    std::array<std::array<float, 3>, 3> at;
    std::array<std::array<float, 2>, 3> places;
    std::array<std::array<uint8_t, 4>, 3> colours;
    for (size_t k = 0; k < 3; ++k) {
      at[k] = kCorners[kFaces[f][k]];
      places[k] = {at[k][0], at[k][1]};
      colours[k] = {static_cast<uint8_t>(255 * at[k][0]), static_cast<uint8_t>(255 * at[k][1]), 51, 255};
    }
    const auto set = [&](int attribute, const auto& of) {
      builder.SetAttributeValuesForFace(attribute, draco::FaceIndex(f), of[0].data(), of[1].data(), of[2].data());
    };
    set(position, at);
    if (has_looks) set(place, places), set(colour, colours);
  }
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  if (has_metadata) {
    auto metadata = std::make_unique<draco::GeometryMetadata>();
    metadata->AddEntryString("made by", "a test");
    mesh->AddMetadata(std::move(metadata));
  }
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method);
  if (!has_looks) encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 14);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
  return {buffer.data(), buffer.size()};
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
