// Hostile glTF files: whatever the bytes, they are refused in one line, or become a scene that holds together.
//
// An input is a file as it stands, .gltf or .glb, or the two chunks of a .glb, JSON first, with a zero byte between them: the file
// is then made here, or hardly any mutation would get past its lengths.
#include <iterator>

#include "scene/gltf_reader.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/scene_check.h"
#include "tests/scene/gltf_packed_parts.h"

namespace nlg::fuzz {
namespace {

std::string binaryOf(std::string json, std::string payload) {
  const auto word = [](size_t value) { return bytesOf<uint32_t>({static_cast<uint32_t>(value)}); };
  json.resize((json.size() + 3) / 4 * 4, ' ');
  payload.resize((payload.size() + 3) / 4 * 4, '\0');
  return "glTF" + word(2) + word(28 + json.size() + payload.size()) + word(json.size()) + "JSON" + json + word(payload.size()) +
         std::string("BIN\0", 4) + payload;
}

std::string wholeFile(std::string_view input) {
  const size_t end = input.find('\0');
  if (!input.starts_with('{') || end == input.npos) return std::string(input);
  return binaryOf(std::string(input.substr(0, end)), std::string(input.substr(end + 1)));
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
  const std::pair<const char*, Parts> files[] = {
      {"square", Parts()},
      {"lit", litSquare()},
      {"meshopt", meshoptSquare()},
      {"meshopt_sequence", meshoptSquare("INDICES")},
      {"draco", dracoParts(dracoSquare(draco::MESH_EDGEBREAKER_ENCODING, draco::DT_FLOAT32, true))},
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
