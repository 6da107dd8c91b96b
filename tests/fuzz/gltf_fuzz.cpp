// Hostile glTF files: whatever the bytes, they are refused in one line, or become a scene that holds together.
//
// An input is a file as it stands, .gltf or .glb, or the two chunks of a .glb, JSON first, with a zero byte between them: the file
// is then made here, or hardly any mutation would get past its lengths.
#include <iterator>

#include "scene/gltf/gltf_reader.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/scene_check.h"
#include "tests/scene/gltf/gltf_packed_parts.h"
#include "tests/scene/image/hand_built_images.h"

namespace nlg::fuzz {
namespace {

std::string wholeFile(std::string_view input) {
  const size_t end = input.find('\0');
  if (!input.starts_with('{') || end == input.npos) return std::string(input);
  return glbOf(std::string(input.substr(0, end)), std::string(input.substr(end + 1)));
}

std::string chunksOf(const Parts& parts) { return parts.json("") + '\0' + parts.bin; }

Parts litSquare() {
  Parts parts;
  parts.nodes = R"([{"mesh":0,"children":[1,2],"scale":[2,-1,1],"rotation":[0,0,0.6,0.8],"translation":[1,2,3]},)"
                R"({"camera":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,5,6,7,1]},{"extensions":{"KHR_lights_punctual":{"light":1}}}])";
  parts.primitives = R"([{"attributes":{"POSITION":0},"indices":1,"material":0},{"attributes":{"POSITION":0},"mode":5},)"
                     R"({"attributes":{"POSITION":2},"mode":6}])";
  parts.accessors =
      R"([{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},{"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"},)"
      R"({"componentType":5126,"count":4,"type":"VEC3","sparse":{"count":2,"indices":{"bufferView":1,"componentType":5123},)"
      R"("values":{"bufferView":0}}}])";
  parts.more =
      R"(,"scene":0,"cameras":[{"type":"perspective","perspective":{"yfov":0.7,"znear":0.1}}],"materials":[{"doubleSided":true,)"
      R"("emissiveFactor":[1,0.5,0],"pbrMetallicRoughness":{"baseColorFactor":[0.5,0.5,0.5,1]},)"
      R"("extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":5}}}],"extensions":{"KHR_lights_punctual":{"lights":[)"
      R"({"type":"directional","intensity":3},{"type":"spot","color":[1,1,0],"spot":{"innerConeAngle":0.1,"outerConeAngle":0.5}}]}},)"
      R"("extensionsUsed":["KHR_lights_punctual","KHR_materials_emissive_strength"])";
  return parts;
}

// A square with an image for its colour, for what shines, and for what it lets through.
Parts texturedSquare(const std::string& image) {
  Parts parts;
  parts.add(bytesOf<float>({0, 1, 1, 1, 1, 0, 0, 0}), R"("componentType":5126,"count":4,"type":"VEC2")");
  parts.add(bytesOf<uint8_t>({255, 0, 0, 255, 0, 255, 0, 9, 1, 2, 3, 4, 5, 6, 7, 8}),
            R"("componentType":5121,"normalized":true,"count":4,"type":"VEC4")");
  parts.add(image);
  parts.primitives =
      R"([{"attributes":{"POSITION":0,"TEXCOORD_0":2,"COLOR_0":3},"indices":1,"material":0},{"attributes":{"POSITION":0},"indices":1,"material":1}])";
  parts.more =
      R"(,"images":[{"bufferView":4,"mimeType":"image/png"},{"uri":"square.bin"}],"samplers":[{"wrapS":33071,"wrapT":33648}],)"
      R"("textures":[{"source":0,"sampler":0},{"extensions":{"EXT_texture_webp":{"source":0}}},{"extensions":{"KHR_texture_basisu":{"source":1}}}],)"
      R"("materials":[{"alphaMode":"MASK","alphaCutoff":0.4,"emissiveFactor":[1,1,1],"emissiveTexture":{"index":1},)"
      R"("pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.9],"baseColorTexture":{"index":0,"extensions":{"KHR_texture_transform":{"offset":[0.5,0],)"
      R"("rotation":1,"scale":[2,3],"texCoord":0}}}},"extensions":{"KHR_materials_transmission":{"transmissionFactor":0.5,"transmissionTexture":{"index":0}}}},)"
      R"({"alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.5],"baseColorTexture":{"index":2}}}])";
  return parts;
}

// A square on two joints, another that is morphed, and instances of a third; a coarser level, a hidden node, a second scene.
Parts posedSquare() {
  Parts parts;
  const std::string joints = bytesOf<uint8_t>({0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0});
  parts.add(joints, R"("componentType":5121,"count":4,"type":"VEC4")");
  parts.add(joints, R"("componentType":5121,"normalized":true,"count":4,"type":"VEC4")");
  parts.primitives =
      R"([{"attributes":{"POSITION":0,"JOINTS_0":2,"WEIGHTS_0":3},"indices":1,"targets":[{"POSITION":0}]}],"weights":[0.5])";
  parts.nodes =
      R"([{"mesh":0,"skin":0},{"mesh":0,"weights":[2]},{"mesh":0,"name":"a_LOD1","extensions":{"EXT_mesh_gpu_instancing":{)"
      R"("attributes":{"TRANSLATION":0}},"MSFT_lod":{"ids":[3]}}},{"mesh":0,"name":"UCX_a"},)"
      R"({"children":[5],"extensions":{"KHR_node_visibility":{"visible":false}}},{"extras":{"nlg_ignore":true}}])";
  parts.scenes = R"([{"nodes":[0,1,2,4]},{"name":"Night","nodes":[3]}])";
  parts.more = R"(,"skins":[{"joints":[1,2]}],"extensionsUsed":["KHR_materials_sheen","XYZ_other"])";
  return parts;
}

// What a .gltf may name: "square.bin".
std::unique_ptr<ScratchFile> bufferBeside() {
  auto buffer = std::make_unique<ScratchFile>("square.bin");
  buffer->write(kSquare);
  return buffer;
}

}  // namespace

void readOne(std::string_view bytes) {
  static const ScratchFile file("scene.gltf");
  static const std::unique_ptr<ScratchFile> buffer = bufferBeside();
  file.write(wholeFile(bytes));
  isTaken([] { checkScene(readGltf(file.path()).scene); });
}

Seeds seeds() {
  const std::pair<const char*, Parts> files[] = {{"square", Parts()},
                                                 {"lit", litSquare()},
                                                 {"posed", posedSquare()},
                                                 {"png", texturedSquare(png(2, 2, pixels(4, "\x10\x80\xf0\x40")))},
                                                 {"jpg", texturedSquare(jpeg(2, 10, 20, 30))},
                                                 {"webp", texturedSquare(webp(2, 2, pixels(4, "\x10\x80\xf0\x40")))},
                                                 {"meshopt", meshoptSquare()},
                                                 {"meshopt_sequence", meshoptSquare("INDICES")},
                                                 {"draco", dracoParts(dracoSquare(draco::MESH_EDGEBREAKER_ENCODING, true))},
                                                 {"draco_sequential", dracoParts(dracoSquare(draco::MESH_SEQUENTIAL_ENCODING))}};
  Seeds seeds = {{"beside.gltf", Parts().json("square.bin")}};
  for (const auto& [name, parts] : files) {
    seeds.emplace_back(std::string(name) + ".gltf", parts.text());
    seeds.emplace_back(std::string(name) + ".glb", parts.binary());
    seeds.emplace_back(std::string(name) + ".chunks", chunksOf(parts));
  }
  return seeds;
}

std::string mutated(std::string bytes, size_t max_size, Random& random) {
  const size_t end = bytes.find('\0');
  if (!bytes.starts_with('{') || end == bytes.npos) return mutatedTextOrBlindly(std::move(bytes), max_size, random);
  std::string json = bytes.substr(0, end), payload = bytes.substr(end + 1);
  if (random.chance(0.3)) {
    payload = mutatedBlindly(std::move(payload), max_size - json.size() - 1);
  } else {
    json = mutatedTextOrBlindly(std::move(json), max_size - payload.size() - 1, random);
  }
  return json + '\0' + payload;
}

}  // namespace nlg::fuzz
