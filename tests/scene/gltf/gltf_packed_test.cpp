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

// Packed positions behind the indices of the square.
void packVertices(const std::string& packed, const std::string& view, const std::string& members, Parts* parts) {
  parts->bin = kSquare.substr(48) + packed;
  parts->views = "[{" + view + R"(,"extensions":{"EXT_meshopt_compression":{"buffer":0,"byteOffset":12,"byteLength":)" +
                 std::to_string(packed.size()) + R"(,"count":4,"mode":"ATTRIBUTES",)" + members +
                 R"(}}},{"buffer":0,"byteLength":12}])";
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
  packVertices(packed, R"("buffer":0,"byteLength":48)", R"("byteStride":12,"filter":"EXPONENTIAL")", &parts);
  expectTheSquare(read(parts), "exponents");
}

TEST_F(GltfPacked, MeshoptOfQuantizedPositionsIsRead) {
  Parts parts = meshoptSquare();
  const std::string vertices = bytesOf<uint16_t>({0, 0, 0, 0, 65535, 0, 0, 0, 65535, 65535, 0, 0, 0, 65535, 0, 0});
  const std::string packed = packedVertices(vertices, 8);
  packVertices(packed, R"("buffer":1,"byteStride":8,"byteLength":32)", R"("byteStride":8)", &parts);
  parts.accessors = replaced(parts.accessors, "5126", R"(5123,"normalized":true)");
  parts.more = R"(,"extensionsRequired":["KHR_mesh_quantization","EXT_meshopt_compression"],)"
               R"("extensionsUsed":["KHR_mesh_quantization","EXT_meshopt_compression"])";
  expectTheSquare(read(parts), "quantized and packed");
}

TEST_F(GltfPacked, DracoIsReadFromTextAndBinary) {
  for (const auto method : {draco::MESH_EDGEBREAKER_ENCODING, draco::MESH_SEQUENTIAL_ENCODING}) {
    for (const bool has_metadata : {false, true}) {
      const Parts parts = dracoParts(dracoSquare(method, has_metadata));
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
  parts.add(stream);
  parts.primitives = replaced(dracoParts(stream).primitives, R"("bufferView":0)", R"("bufferView":2)");
  expectTheSquare(read(parts), "both");
}

}  // namespace
}  // namespace nlg
