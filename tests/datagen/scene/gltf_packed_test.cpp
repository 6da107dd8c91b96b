// Compressed glTF files: packed here with the libraries' own encoders, read, and spoilt.
#include "tests/datagen/scene/gltf_parts.h"

#include <meshoptimizer.h>

namespace nlg {
namespace {

using GltfPacked = GltfFiles;

std::string packedVertices(const std::string& vertices, size_t stride) {
  const size_t count = vertices.size() / stride;
  std::string packed(meshopt_encodeVertexBufferBound(count, stride), '\0');
  auto* bytes = reinterpret_cast<unsigned char*>(packed.data());
  packed.resize(meshopt_encodeVertexBuffer(bytes, packed.size(), vertices.data(), count, stride));
  return packed;
}

using Encode = size_t (*)(unsigned char*, size_t, const unsigned int*, size_t);

std::string packedIndices(const std::vector<unsigned>& indices, Encode encode, size_t bound) {
  std::string packed(bound, '\0');
  packed.resize(encode(reinterpret_cast<unsigned char*>(packed.data()), bound, indices.data(), indices.size()));
  return packed;
}

// The square of Parts, its views packed by EXT_meshopt_compression; they lie in buffer 1, which does not exist.
Parts meshoptSquare(const std::string& index_mode = "TRIANGLES") {
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
    expectTheSquare(readGltf(write("square.glb", parts.binary())), mode);
    write("packed.bin", parts.bin);
    expectTheSquare(readGltf(write("beside.gltf", parts.json("packed.bin"))), mode);
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
    {"what view 0 was unpacked to", R"("byteLength":12,"extensions":{"EXT_meshopt_compression":{"buffer":0)",
     R"("byteLength":12,"extensions":{"EXT_meshopt_compression":{"buffer":2)",
     "buffer view 1: EXT_meshopt_compression: expected a buffer below 2, got 2"},
    {"the fallback itself", R"("EXT_meshopt_compression":{"buffer":0)", R"("EXT_meshopt_compression":{"buffer":1)",
     "buffer view 0"},
    {"offset past the buffer", R"("byteOffset":0,"byteLength")", R"("byteOffset":100000,"byteLength")",
     "expected packed bytes within the buffer's"},
    {"offset of 33 bits", R"("byteOffset":0,"byteLength")", R"("byteOffset":4294967296,"byteLength")",
     "bufferViews[0].extensions.EXT_meshopt_compression.byteOffset"},
    {"negative length", R"("byteOffset":0,"byteLength":)", R"("byteOffset":0,"byteLength":-)",
     "EXT_meshopt_compression.byteLength"},
    {"stride of no multiple", R"("byteStride":12,"count")", R"("byteStride":10,"count")", "a multiple of 4, got 10"},
    {"stride too large", R"("byteStride":12,"count")", R"("byteStride":260,"count")", "got 260"},
    {"stride of indices", R"("byteStride":2)", R"("byteStride":1)", "expected a byteStride of 2 or 4, got 1"},
    {"another count", R"("count":4,"mode")", R"("count":5,"mode")", "as the view's byteLength, got 60"},
    {"no count", R"("count":4,"mode")", R"("mode")", "expected count, got none"},
    {"count as text", R"("count":4,"mode")", R"("count":"4","mode")", "EXT_meshopt_compression.count: expected a JSON index"},
    {"huge count", R"("byteLength":48,"byteStride":12,"extensions")", R"("byteLength":12884901876,"extensions")",
     "as the view's byteLength, got 48"},
    {"corners not in threes", R"("count":6,"mode")", R"("count":5,"mode")", "expected a count that is a multiple of 3, got 5"},
    {"unknown mode", "ATTRIBUTES", "COLOURS", "expected the mode ATTRIBUTES, TRIANGLES or INDICES, got COLOURS"},
    {"mode of the other kind", "ATTRIBUTES", "TRIANGLES", "expected a byteStride of 2 or 4, got 12"},
    {"unknown filter", R"("mode":"ATTRIBUTES")", R"("mode":"ATTRIBUTES","filter":"BLUR")", "got BLUR"},
    {"filter of another stride", R"("mode":"ATTRIBUTES")", R"("mode":"ATTRIBUTES","filter":"OCTAHEDRAL")",
     "expected a byteStride of 4 or 8, got 12"},
    {"filter of indices", R"("mode":"TRIANGLES")", R"("mode":"TRIANGLES","filter":"EXPONENTIAL")",
     "expected no filter of indices"},
    {"buffer that is no fallback", R"("fallback":true)", R"("fallback":false)", "buffers[1]: expected a uri, got none"},
    {"fallback as text", R"("fallback":true)", R"("fallback":"true")", "fallback: expected a JSON boolean"},
    {"plain view of the fallback", R"({"buffer":1,"byteOffset":48)",
     R"({"buffer":1,"byteOffset":48},{"buffer":1,"byteOffset":48)", "byteLength"}};

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

TEST_F(GltfPacked, EveryTruncationOfMeshoptDataIsRefused) {
  const Parts whole = meshoptSquare();
  const size_t at = whole.views.find("\"byteLength\":", whole.views.find("EXT_meshopt")) + 13;
  const size_t size = std::stoul(whole.views.substr(at));
  for (size_t kept = 0; kept < size; ++kept) {
    Parts parts = whole;
    parts.views.replace(at, std::to_string(size).size(), std::to_string(kept));
    const std::string error = errorOf(parts.text());
    EXPECT_NE(error.find("buffer view 0: EXT_meshopt_compression: expected "), std::string::npos) << kept << ": " << error;
  }
}

// Bytes changed at random: an error or a scene, never a crash.
void surviveDamage(const std::string& whole, const std::string& path, int rounds) {
  uint32_t state = 1;
  const auto next = [&] { return (state = state * 1664525u + 1013904223u) >> 8; };
  int refused_count = 0;
  for (int round = 0; round < rounds; ++round) {
    std::string damaged = whole;
    for (uint32_t i = 0; i < 1 + next() % 3; ++i) damaged[next() % damaged.size()] = static_cast<char>(next());
    std::ofstream(path, std::ios::binary) << damaged;
    try {
      readGltf(path);
    } catch (const InputError& error) {
      ++refused_count;
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
  EXPECT_GT(refused_count, rounds / 10);
  EXPECT_LT(refused_count, rounds);
}

TEST_F(GltfPacked, MeshoptSurvivesRandomDamage) { surviveDamage(meshoptSquare().binary(), write("damaged.glb", ""), 1000); }

}  // namespace
}  // namespace nlg
