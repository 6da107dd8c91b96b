// Compressed glTF files: packed here with the libraries' own encoders, read, and spoilt.
#include "tests/scene/gltf/gltf_packed_parts.h"

namespace nlg {
namespace {

using GltfPacked = GltfFiles;

void expectTheSquare(const Scene& scene, const std::string& what) {
  ASSERT_EQ(scene.triangles.size(), 2u) << what;
  EXPECT_EQ(scene.positions.size(), 4u) << what;
  EXPECT_NEAR(areaOf(scene), 1.0, 1e-6) << what;
  expectNear(normalOf(scene, 0), {0, 0, 1}, what + ": normal");
}

TEST_F(GltfPacked, MeshoptIsReadFromTextAndBinary) {
  for (const char* mode : {"TRIANGLES", "INDICES"}) {
    const Parts parts = meshoptSquare(mode);
    expectTheSquare(read(parts), mode);
    expectTheSquare(readGltf(write("square.glb", parts.binary())).scene, mode);
    write("packed.bin", parts.bin);
    expectTheSquare(readGltf(write("beside.gltf", parts.json("packed.bin"))).scene, mode);
  }
}

// 2^E times a mantissa, by the extension: E in the upper 8 bits, the mantissa in the lower 24.
TEST_F(GltfPacked, MeshoptFiltersAreUndone) {
  const auto halves = [](int mantissa) { return static_cast<uint32_t>(0xff000000u | static_cast<uint32_t>(mantissa)); };
  const uint32_t zero = halves(0), one = halves(2);
  const std::string vertices = bytesOf<uint32_t>({zero, zero, zero, one, zero, zero, one, one, zero, zero, one, zero});
  const std::string packed = packedVertices(vertices, 12);
  Parts parts;
  parts.bin = std::string(kSquare.substr(48)) + packed;
  parts.views =
      R"([{"buffer":0,"byteLength":48,"extensions":{"EXT_meshopt_compression":{"buffer":0,"byteOffset":12,"byteLength":)" +
      std::to_string(packed.size()) +
      R"(,"byteStride":12,"count":4,"mode":"ATTRIBUTES","filter":"EXPONENTIAL"}}},{"buffer":0,"byteLength":12}])";
  expectTheSquare(read(parts), "exponents");
}

TEST_F(GltfPacked, MeshoptOfQuantizedPositionsIsRead) {
  Parts parts = meshoptSquare();
  const std::string vertices = bytesOf<uint16_t>({0, 0, 0, 0, 65535, 0, 0, 0, 65535, 65535, 0, 0, 0, 65535, 0, 0});
  const std::string packed = packedVertices(vertices, 8);
  parts.bin = kSquare.substr(48) + packed;
  parts.views =
      R"([{"buffer":1,"byteStride":8,"byteLength":32,"extensions":{"EXT_meshopt_compression":{"buffer":0,"byteOffset":12,"byteLength":)" +
      std::to_string(packed.size()) + R"(,"byteStride":8,"count":4,"mode":"ATTRIBUTES"}}},{"buffer":0,"byteLength":12}])";
  parts.accessors = replaced(parts.accessors, "5126", R"(5123,"normalized":true)");
  parts.more = R"(,"extensionsRequired":["KHR_mesh_quantization","EXT_meshopt_compression"],)"
               R"("extensionsUsed":["KHR_mesh_quantization","EXT_meshopt_compression"])";
  expectTheSquare(read(parts), "quantized and packed");
}

struct Spoilt {
  const char* name;
  const char* from;
  const char* to;
  const char* error;  // what its line must hold
};

const Spoilt kSpoiltMeshopt[] = {
    {"no such buffer", R"("EXT_meshopt_compression":{"buffer":0)", R"("EXT_meshopt_compression":{"buffer":7)",
     "buffer view 0: EXT_meshopt_compression: expected a buffer below 2, got 7"},
    {"offset past the buffer", R"("byteOffset":0,"byteLength")", R"("byteOffset":100000,"byteLength")",
     "expected packed bytes within the buffer's"},
    {"stride of no multiple", R"("byteStride":12,"count")", R"("byteStride":10,"count")", "a multiple of 4, got 10"},
    {"another count", R"("count":4,"mode")", R"("count":5,"mode")", "as the view's byteLength, got 60"},
    {"corners not in threes", R"("count":6,"mode")", R"("count":5,"mode")", "expected a count that is a multiple of 3, got 5"},
    {"unknown mode", "ATTRIBUTES", "COLOURS", "expected the mode ATTRIBUTES, TRIANGLES or INDICES, got COLOURS"},
    {"filter of another stride", R"("mode":"ATTRIBUTES")", R"("mode":"ATTRIBUTES","filter":"OCTAHEDRAL")",
     "expected a byteStride of 4 or 8, got 12"},
    {"filter of indices", R"("mode":"TRIANGLES")", R"("mode":"TRIANGLES","filter":"EXPONENTIAL")",
     "expected no filter of indices"},
    {"plain view of the fallback", R"({"buffer":1,"byteOffset":48)",
     R"({"buffer":1,"byteOffset":48},{"buffer":1,"byteOffset":48)", "bufferViews[1]: expected all members that glTF requires"}};

TEST_F(GltfPacked, SpoiltMeshoptIsRefusedByPlace) {
  for (const Spoilt& spoilt : kSpoiltMeshopt) {
    const std::string error = errorOf(replaced(meshoptSquare().text(), spoilt.from, spoilt.to));
    EXPECT_NE(error.find(spoilt.error), std::string::npos) << spoilt.name << ": " << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << spoilt.name << ": " << error;
  }
}

// 64 bytes for one is what the format can reach; a file that promises more gets no memory for it.
TEST_F(GltfPacked, MeshoptPromisesBeyondItsBytesAreRefusedBeforehand) {
  Parts parts = meshoptSquare();
  parts.views = replaced(parts.views, R"("byteLength":48,"byteStride":12)", R"("byteLength":3000000000,"byteStride":12)");
  parts.views = replaced(parts.views, R"("count":4)", R"("count":250000000)");
  EXPECT_NE(errorOf(parts.text()).find("expected at most 64 bytes for each of"), std::string::npos) << errorOf(parts.text());
}

TEST_F(GltfPacked, DracoIsReadFromTextAndBinary) {
  for (const auto method : {draco::MESH_EDGEBREAKER_ENCODING, draco::MESH_SEQUENTIAL_ENCODING}) {
    for (const bool has_metadata : {false, true}) {
      const Parts parts = dracoParts(dracoSquare(method, draco::DT_FLOAT32, has_metadata));
      const std::string name = "method " + std::to_string(method) + (has_metadata ? " with metadata" : "");
      expectTheSquare(read(parts), name);
      expectTheSquare(readGltf(write("square.glb", parts.binary())).scene, name);
    }
  }
}

// Some exporters only say that it is used.
TEST_F(GltfPacked, DracoIsReadWhereNoExtensionIsRequired) {
  Parts parts = dracoParts(dracoSquare(draco::MESH_EDGEBREAKER_ENCODING));
  for (const char* said : {R"(,"extensionsUsed":["KHR_draco_mesh_compression"])", ""}) {
    parts.more = said;
    expectTheSquare(read(parts), said);
  }
}

TEST_F(GltfPacked, DracoWinsOverPlainCopies) {
  const std::string stream = dracoSquare(draco::MESH_EDGEBREAKER_ENCODING);
  Parts parts;
  parts.bin = kSquare + stream;
  parts.views =
      replaced(parts.views, "]", R"(,{"buffer":0,"byteOffset":60,"byteLength":)" + std::to_string(stream.size()) + "}]");
  parts.primitives = replaced(dracoParts(stream).primitives, R"("bufferView":0)", R"("bufferView":2)");
  expectTheSquare(read(parts), "both");
}

const Spoilt kSpoiltDraco[] = {{"no such view", R"({"bufferView":0)", R"({"bufferView":4)",
                                "mesh 0, primitive 0: KHR_draco_mesh_compression: expected a bufferView below 1, got 4"},
                               {"no positions", R"("attributes":{"POSITION":0}}})", R"("attributes":{"NORMAL":0}}})",
                                "expected attributes with a POSITION, got none"},
                               {"no such attribute", R"("attributes":{"POSITION":0}}})", R"("attributes":{"POSITION":3}}})",
                                "expected an attribute of the number of POSITION, got 3"},
                               {"strips", R"("indices":1)", R"("indices":1,"mode":5)", "expected mode 4, triangles, got 5"}};

TEST_F(GltfPacked, SpoiltDracoIsRefusedByPlace) {
  const Parts whole = dracoParts(dracoSquare(draco::MESH_EDGEBREAKER_ENCODING));
  for (const Spoilt& spoilt : kSpoiltDraco) {
    const std::string error = errorOf(replaced(whole.text(), spoilt.from, spoilt.to));
    EXPECT_NE(error.find(spoilt.error), std::string::npos) << spoilt.name << ": " << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << spoilt.name << ": " << error;
  }
}

TEST_F(GltfPacked, DracoStreamsOfOtherKindsAreRefused) {
  const std::string whole = dracoSquare(draco::MESH_SEQUENTIAL_ENCODING);
  const auto errorWith = [&](const std::string& stream) { return errorOf(dracoParts(stream).text()); };
  // bytes 5 and 6 are the version, 7 the kind of geometry, from 11 on the number of faces
  std::string old = whole, cloud = whole, huge = whole;
  old[6] = 1;
  cloud[7] = 0;
  huge.replace(11, 1, "\xff\xff\xff\x3f");
  EXPECT_NE(errorWith(old).find("expected version 2.2 of Draco's bit stream, got 2.1"), std::string::npos) << errorWith(old);
  EXPECT_NE(errorWith(cloud).find("expected a Draco mesh, got other bytes"), std::string::npos) << errorWith(cloud);
  EXPECT_NE(errorWith(huge).find("expected at most 64 faces for each of"), std::string::npos) << errorWith(huge);
  const std::string integers = dracoSquare(draco::MESH_SEQUENTIAL_ENCODING, draco::DT_INT32);
  EXPECT_NE(errorWith(integers).find("expected positions of three floats"), std::string::npos) << errorWith(integers);
}

// What compresses best is read: a plane of 20,000 equal triangles, in less than three bits each. With 255 components instead of
// three its decoder would take 1,020 bytes for each of 10,201 points before it looks for the first of them.
TEST_F(GltfPacked, DracoPromisesBeyondItsBytesAreRefusedBeforehand) {
  Corners corners;
  Faces faces;
  for (uint32_t i = 0; i < 101 * 101; ++i) {
    corners.emplace_back(static_cast<float>(i % 101), static_cast<float>(i / 101), 0.0f);
    if (i % 101 == 100 || i / 101 == 100) continue;
    faces.push_back({i, i + 1, i + 102});
    faces.push_back({i, i + 102, i + 101});
  }
  std::string stream = dracoStream(corners, faces, draco::MESH_EDGEBREAKER_ENCODING);
  EXPECT_LT(stream.size(), 7500u);
  EXPECT_NEAR(areaOf(read(dracoParts(stream))), 1e4, 1.0) << "positions are rounded to 1/16384 of the side";
  // the attribute's description: position, floats, 3 of them, not normalized, number 0
  const size_t attribute = stream.find(std::string("\x00\x09\x03\x00\x00", 5));
  ASSERT_NE(attribute, std::string::npos);
  stream[attribute + 2] = '\xff';
  const std::string error = errorOf(dracoParts(stream).text());
  EXPECT_NE(error.find("expected attributes of at most "), std::string::npos) << error;
  EXPECT_NE(error.find("bytes, got 10405020"), std::string::npos) << error;
}

}  // namespace
}  // namespace nlg
