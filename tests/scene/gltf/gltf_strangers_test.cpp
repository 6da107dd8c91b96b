// glTF files as strangers write them: what no eye sees, poses, units that only a sign tells, and one part that is broken.
#include "tests/scene/gltf/gltf_packed_parts.h"

#include <tuple>

#include <fmt/format.h>
#include <tiny_gltf.h>

#include "scene/gltf/gltf_light.h"
#include "scene/gltf/gltf_packed.h"
#include "tool/error.h"

namespace nlg {
namespace {

class GltfStrangers : public GltfFiles {
 protected:
  GltfLevel level(const Parts& parts, const GltfChoice& choice = {}) const {
    return readGltf(write("stranger.gltf", parts.text()), 1.0, kDenseTransmissive, choice);
  }

  static std::string namesOf(const Scene& scene) {
    std::string names;
    for (const SceneObject& object : scene.objects) names += (names.empty() ? "" : " ") + object.name;
    return names;
  }

  static std::string linesOf(const GltfLevel& level) {
    std::string lines;
    for (const std::string& note : level.notes) lines += note + "\n";
    return lines;
  }

  static void expectSays(const GltfLevel& level, const std::string& words) {
    EXPECT_NE(linesOf(level).find(words), std::string::npos) << "expected " << words << "\ngot " << linesOf(level);
  }
};

// Nodes with the square, all of them roots.
Parts nodesOf(const std::vector<std::string>& nodes) {
  Parts parts;
  parts.nodes = parts.scenes = "";
  for (size_t i = 0; i < nodes.size(); ++i) {
    parts.nodes += (i > 0 ? "," : "[") + nodes[i];
    parts.scenes += (i > 0 ? "," : R"([{"nodes":[)") + std::to_string(i);
  }
  parts.nodes += "]";
  parts.scenes += "]}]";
  return parts;
}

std::string named(const std::string& name, const std::string& more = "") {
  return R"({"mesh":0,"name":")" + name + "\"" + more + "}";
}

// --- what no eye sees

TEST_F(GltfStrangers, LeavesOutWhatNamesSayIsForNoEye) {
  const std::tuple<const char*, std::vector<const char*>, const char*> cases[] = {
      {"the wall", {"UCX_wall_01", "UBX_wall", "USP_wall", "ucp_wall", "MCDCX_wall"}, "5 objects"},
      {"Wall", {"Kill-colonly", "kill_ConvColOnly", "Kill$colonly.001", "far-noimp", "nav-navmesh", "occ-occonly2"}, "6 objects"},
      {"Skylight",
       {"SkyDome", "sky_box.001", "Sky"},
       "3 objects (SkyDome, sky_box.001, Sky) left out, for a sky and no wall, by its name"},
      {"Arch_LOD0", {"Arch_LOD1", "Arch_LOD2"}, "2 objects (Arch_LOD1, Arch_LOD2) left out, coarser levels of detail by name"},
      {"Arch_LOD0.001", {"arch_lod1.001", "Arch-LOD3"}, "2 objects"},
      {"Arch", {"Arch_LOD1"}, "1 object (Arch_LOD1) left out"},
      {"Arch_LOD2", {"Arch_LOD3"}, "1 object (Arch_LOD3) left out"}};
  for (const auto& [stays, goes, words] : cases) {
    std::vector<std::string> nodes = {named(stays)};
    for (const char* name : goes) nodes.push_back(named(name));
    const GltfLevel read = level(nodesOf(nodes));
    EXPECT_EQ(namesOf(read.scene), stays);
    if (std::string(words).size() > 9) expectSays(read, words);
    expectSays(read, "an extra nlg_ignore of false keeps a node");
  }
}

TEST_F(GltfStrangers, KeepsWhatOnlyLooksLikeSuchANameOrIsMarked) {
  const char* const kept[] = {"Arch_LOD1", "colonly", "notcolonly", "door-col", "wall-convcol", "UCXwall", "LOD2", "melody"};
  for (const char* name : kept) {
    const GltfLevel read = level(nodesOf({named(name)}));
    EXPECT_EQ(namesOf(read.scene), name);
    EXPECT_TRUE(read.notes.empty()) << linesOf(read);
  }
  EXPECT_EQ(namesOf(level(nodesOf({named("UCX_a", R"(,"extras":{"nlg_ignore":false})")})).scene), "UCX_a");
}

TEST_F(GltfStrangers, LeavesOutByMarksAndPatternsWithAllThatHangs) {
  const std::string lamp = R"(,"extensions":{"KHR_lights_punctual":{"light":0}})";
  const std::pair<const char*, const char*> cases[] = {
      {R"("extensions":{"KHR_node_visibility":{"visible":false}})",
       "1 lamp, 1 object (child) left out, hidden by KHR_node_visibility"},
      {R"("extras":{"nlg_ignore":true})", "1 lamp, 1 object (child) left out, by nlg_ignore"},
      {R"("extras":{"nlg_ignore":1})", "1 lamp, 1 object (child) left out, by nlg_ignore"},
      {R"("name":"Group.007")", "1 lamp, 1 object (child) left out, by --leave-out Gr*.00?"}};
  for (const auto& [mark, words] : cases) {
    Parts parts;
    parts.nodes =
        "[" + named("wall") + R"(,{"children":[2,3],)" + mark + "}," + named("child") + R"(,{"name":"lamp")" + lamp + "}]";
    parts.scenes = R"([{"nodes":[0,1]}])";
    parts.more = R"(,"extensions":{"KHR_lights_punctual":{"lights":[{"type":"point"}]}})";
    const GltfLevel read = level(parts, {"", {"Gr*.00?", "no such*"}});
    EXPECT_EQ(namesOf(read.scene), "wall") << mark;
    EXPECT_TRUE(read.scene.light.lamps.empty()) << mark;
    expectSays(read, words);
    expectSays(read, "--leave-out no such*: no node");
  }
  const GltfLevel visible = level(nodesOf({named("a", R"(,"extensions":{"KHR_node_visibility":{"visible":true}})")}));
  EXPECT_EQ(namesOf(visible.scene), "a");
}

TEST_F(GltfStrangers, NamesWhatOtherScenesHoldAndReadsThemByName) {
  Parts parts;
  parts.nodes = "[" + named("house") + "," + named("door") + R"(,{"extensions":{"KHR_lights_punctual":{"light":0}}},)" +
                named("shed") + "]";
  parts.scenes = R"([{"nodes":[0]},{"name":"Night","nodes":[0,1,2]}])";
  parts.more = R"(,"extensions":{"KHR_lights_punctual":{"lights":[{"type":"point"}]}})";
  const GltfLevel read = level(parts);
  EXPECT_EQ(namesOf(read.scene), "house");
  expectSays(read, "scene 2 of 2 is not read: 1 lamp, 1 object (door); --scene-name Night");
  expectSays(read, "in no scene of the file, and not read: 1 object (shed)");
  for (const char* name : {"Night", "2"}) {
    const GltfLevel night = level(parts, {name, {}});
    EXPECT_EQ(namesOf(night.scene), "house door") << name;
    EXPECT_EQ(night.scene.light.lamps.size(), 1u);
  }
  EXPECT_THROW(level(parts, {"Day", {}}), UsageError);
  // what is hidden here and shown there counts there, too
  Parts hidden = parts;
  hidden.scenes = replaced(hidden.scenes, "[0]", "[0,4]");
  hidden.nodes.back() = ',';
  hidden.nodes += R"({"children":[1],"extensions":{"KHR_node_visibility":{"visible":false}}}])";
  expectSays(level(hidden), "1 object (door) left out, hidden by KHR_node_visibility");
  expectSays(level(hidden), "scene 2 of 2 is not read: 1 lamp, 1 object (door); --scene-name Night");
  EXPECT_EQ(namesOf(level(hidden, {"Night", {}}).scene), "house door");
  parts.more += R"(,"scene":7)";
  expectSays(level(parts), "scene 8 of 2 by default: the first one instead");
}

// --- the pose of the file

// A second set of four vectors behind the square's: what a morph target adds.
Parts morphing(const std::string& node, const std::string& primitive = "") {
  Parts parts;
  parts.add(bytesOf<float>({0, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0, 2}), R"("componentType":5126,"count":4,"type":"VEC3")");
  parts.primitives = R"([{"attributes":{"POSITION":0},"indices":1,"targets":[{"POSITION":2},{"NORMAL":2}]}])" + primitive;
  parts.nodes = "[" + node + "]";
  return parts;
}

TEST_F(GltfStrangers, MorphTargetsStandAtTheFilesWeights) {
  const auto heightOf = [&](const std::string& node, const std::string& mesh_weights) {
    const GltfLevel read = level(morphing(node, mesh_weights));
    EXPECT_TRUE(read.notes.empty()) << linesOf(read);
    return corner(read.scene, 0, 0).z;
  };
  EXPECT_EQ(heightOf(R"({"mesh":0})", ""), 0.0);
  // Parts ends the list of primitives with the mesh's end
  EXPECT_EQ(heightOf(R"({"mesh":0})", R"(,"weights":[0.5,9])"), 1.0);
  EXPECT_EQ(heightOf(R"({"mesh":0,"weights":[1,0]})", R"(,"weights":[0.5,9])"), 2.0) << "the node's own come first";
  EXPECT_EQ(heightOf(R"({"mesh":0,"weights":[-0.5]})", ""), -1.0);
}

// The square on joints 0 and 1, half a corner each or as said.
Parts skinned(const std::string& joints, const std::string& weights, const std::string& skin, const std::string& nodes) {
  Parts parts;
  parts.add(joints, R"("componentType":5121,"count":4,"type":"VEC4")");
  parts.add(weights, R"("componentType":5126,"count":4,"type":"VEC4")");
  parts.add(bytesOf<float>({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -5, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}),
            R"("componentType":5126,"count":2,"type":"MAT4")");
  parts.primitives = R"([{"attributes":{"POSITION":0,"JOINTS_0":2,"WEIGHTS_0":3},"indices":1}])";
  parts.nodes = nodes;
  parts.scenes = R"([{"nodes":[0,1,2]}])";
  parts.more = R"(,"skins":[)" + skin + "]";
  return parts;
}

const std::string kOnJoint0 = bytesOf<uint8_t>({0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0});
std::string weightsOf(float first, float second) {
  std::string weights;
  for (int i = 0; i < 4; ++i) weights += bytesOf<float>({first, second, 0, 0});
  return weights;
}

TEST_F(GltfStrangers, SkinsStandWhereTheirJointsAre) {
  // the skinned node stands 100 to the side, under a parent: nothing of it counts
  const std::string nodes =
      R"([{"mesh":0,"skin":0,"translation":[100,0,0],"name":"door"},{"translation":[8,0,0],"children":[3]},)"
      R"({"translation":[0,4,0]},{"translation":[0,0,1]}])";
  const std::string skin = R"({"joints":[3,2],"inverseBindMatrices":4})";
  const struct {
    float first, second;
    const char* skin;
    glm::dvec3 lower_left;
  } cases[] = {{1, 0, skin.c_str(), {3, 0, 1}},            // 8 - 5
               {0, 1, skin.c_str(), {0, 4, 0}},            // its matrix is one
               {0.5f, 0.5f, skin.c_str(), {1.5, 2, 0.5}},  // the mean
               {2, 2, skin.c_str(), {1.5, 2, 0.5}},        // weights that do not add up to 1
               {0, 0, skin.c_str(), {3, 0, 1}},            // nor to anything: the first joint
               {1, 0, R"({"joints":[3,2]})", {8, 0, 1}}};
  for (const auto& one : cases) {
    const GltfLevel read = level(skinned(kOnJoint0, weightsOf(one.first, one.second), one.skin, nodes));
    EXPECT_EQ(namesOf(read.scene), "door") << linesOf(read);
    expectNear(corner(read.scene, 0, 0), one.lower_left, fmt::format("{} {} {}", one.first, one.second, one.skin));
    EXPECT_EQ(linesOf(read).find("rest pose"), std::string::npos);
  }
  // of 1,000 km off every millimetre is there
  const std::string far = replaced(nodes, "[8,0,0]", "[1e6,0,0]");
  const GltfLevel read = level(skinned(kOnJoint0, weightsOf(1, 0), R"({"joints":[3,2]})", far));
  expectNear(corner(read.scene, 0, 0), {1e6, 0, 1}, "far");
  // a joint that mirrors turns what it carries: the front stays the front
  const std::string mirrored = replaced(nodes, R"({"translation":[0,0,1]})", R"({"scale":[-1,1,1]})");
  expectNear(normalOf(level(skinned(kOnJoint0, weightsOf(1, 0), skin, mirrored)).scene, 0), {0, 0, 1}, "mirrored");
}

// --- instances

Parts instanced(const std::string& attributes) {
  Parts parts;
  // translations, turns as bytes, scales
  parts.add(bytesOf<float>({0, 0, 0, 10, 0, 0, 20, 0, 0}), R"("componentType":5126,"count":3,"type":"VEC3")");
  parts.add(bytesOf<int8_t>({0, 0, 0, 127, 0, 0, 127, 0, 0, 0, 90, 90}),
            R"("componentType":5120,"normalized":true,"count":3,"type":"VEC4")");
  parts.add(bytesOf<float>({1, 1, 1, 2, 2, 2, 3, 3, 3}), R"("componentType":5126,"count":3,"type":"VEC3")");
  parts.nodes = R"([{"mesh":0,"name":"slat","translation":[0,5,0],"extensions":{"EXT_mesh_gpu_instancing":{"attributes":)" +
                attributes + "}}}]";
  parts.more = R"(,"extensionsUsed":["EXT_mesh_gpu_instancing"],"extensionsRequired":["EXT_mesh_gpu_instancing"])";
  return parts;
}

TEST_F(GltfStrangers, InstancesStandWhereTheirAttributesSay) {
  const GltfLevel read = level(instanced(R"({"TRANSLATION":2,"ROTATION":3,"SCALE":4,"_ID":0})"));
  EXPECT_EQ(namesOf(read.scene), "slat 0 slat 1 slat 2");
  EXPECT_TRUE(read.notes.empty()) << linesOf(read);
  ASSERT_EQ(read.scene.triangles.size(), 6u);
  expectNear(corner(read.scene, 0, 1), {1, 5, 0}, "as it is");
  expectNear(corner(read.scene, 2, 1), {8, 5, 0}, "turned by half about z, twice as large");
  expectNear(corner(read.scene, 4, 1), {20, 8, 0}, "by a quarter, thrice as large");
  EXPECT_EQ(level(instanced(R"({"SCALE":4})")).scene.objects.size(), 3u);
  EXPECT_NE(errorOf(instanced(R"({"TRANSLATION":2,"SCALE":9})").text()).find("EXT_mesh_gpu_instancing: SCALE"),
            std::string::npos);
  EXPECT_NE(errorOf(instanced(R"({"TRANSLATION":0,"SCALE":4})").text()).find("expected 4 elements, got 3"), std::string::npos);
}

// --- KHR_meshopt_compression

std::string fromHex(const std::string& digits) {
  std::string bytes;
  for (size_t i = 0; i < digits.size(); i += 2) bytes += static_cast<char>(std::stoi(digits.substr(i, 2), nullptr, 16));
  return bytes;
}

std::string unpackedMeshopt(const std::string& packed, int count, int stride, const std::string& filter,
                            std::string* notes = nullptr) {
  tinygltf::Model model;
  model.buffers.resize(1);
  model.buffers[0].data.assign(packed.begin(), packed.end());
  model.bufferViews.resize(1);
  model.bufferViews[0].byteLength = static_cast<size_t>(count) * static_cast<size_t>(stride);
  const auto number = [](size_t value) { return tinygltf::Value(static_cast<int>(value)); };
  model.bufferViews[0].extensions["KHR_meshopt_compression"] =
      tinygltf::Value(tinygltf::Value::Object{{"buffer", number(0)},
                                              {"byteLength", number(packed.size())},
                                              {"byteStride", number(stride)},
                                              {"count", number(count)},
                                              {"mode", tinygltf::Value(std::string("ATTRIBUTES"))},
                                              {"filter", tinygltf::Value(filter)}});
  SceneBudget bytes_left = SceneBudgets().bytes;
  Oddities odd("test");
  unpackMeshopt("test", model, bytes_left, &odd);
  if (notes != nullptr) *notes = odd.notes().empty() ? "" : odd.notes()[0];
  const std::vector<unsigned char>& unpacked = model.buffers.back().data;
  return {unpacked.begin(), unpacked.end()};
}

// Of meshoptimizer 1.3's encoder (level 3, version 1): all control modes and channels, one of them turned by six bits.
const char* const kVersion1 =
    "a1b9977668152aaaaaaaeaaaaaaa1deaaa00001d00606080608060806080608060806080606080608060806080608060806080606080608060806080"
    "00585858585858585858585858585858585858585858585858585858585858585858585858585858152aaaaaaaaaaaaaaaaaaa00002a0ddddddddddd"
    "dddddddddddddddddddddddddddd000000001a02232232232232232232232232232232baeb0000030303008f062b3f9f3132b2bb7144c5bf75b3f483"
    "e4a5f038c5704001425ba243973addd885d0ae99386e151555555555555555555500000104001f1a0ff8f8f4c4f4c4f210f018381c7c62e262f262e2"
    "62f11e3edddd00000307030f000000000000803f000000000700c6ff0000803f00010062";

TEST_F(GltfStrangers, Version1OfMeshoptIsUnpacked) {
  std::string expected;
  uint32_t random = 1;
  for (uint32_t i = 0; i < 40; ++i) {
    random = random * 1103515245u + 12345u;
    expected += bytesOf<uint32_t>({((i * 2654435761u) & 0x00f0000fu) ^ 0x3f800000u});
    expected += bytesOf<uint16_t>({static_cast<uint16_t>(i * 300), static_cast<uint16_t>(65536 - 7 * i)});
    expected +=
        bytesOf<uint8_t>({7, static_cast<uint8_t>(i % 3), static_cast<uint8_t>(random >> 16), static_cast<uint8_t>(255 - i)});
    expected += bytesOf<float>({1.0f + 0.5f * static_cast<float>(i)});
  }
  const std::string packed = fromHex(kVersion1);
  EXPECT_EQ(unpackedMeshopt(packed, 40, 16, "NONE"), expected);
  std::string notes;
  for (size_t size = 1; size < packed.size(); ++size) {
    unpackedMeshopt(packed.substr(0, size), 40, 16, "NONE", &notes);
    EXPECT_NE(notes.find("buffer view 0: KHR_meshopt_compression: expected packed ATTRIBUTES"), std::string::npos)
        << size << notes;
  }
  unpackedMeshopt(packed + '\0', 40, 16, "NONE", &notes);
  EXPECT_NE(notes, "") << "a byte too many";
}

// --- one broken part

TEST_F(GltfStrangers, ABrokenPartDoesNotRefuseALevel) {
  const std::string good = R"({"attributes":{"POSITION":0},"indices":1})", last = R"({"attributes":{"POSITION":0},"indices":1}])";
  const std::tuple<std::string, std::string, const char*> cases[] = {
      {"]", R"(,{"attributes":{"NORMAL":0},"indices":1}])",
       "mesh 0, primitive 1: POSITION: expected FLOAT VEC3, got none: left out"},
      {"]", R"(,{"attributes":{},"indices":1}])", "mesh 0, primitive 1: POSITION"},
      {"]", R"(,{"attributes":{"POSITION":9},"indices":1}])",
       "mesh 0, primitive 1: POSITION: expected an accessor below 2, got 9"},
      {"]", R"(,{"attributes":{"POSITION":"a"},"indices":1}])", "meshes[0].primitives[1].attributes"},
      {"]", R"(,{"attributes":{"POSITION":0},"indices":9}])", "meshes[0].primitives[1].indices"},
      {"]", R"(,{"attributes":{"POSITION":0},"indices":18446744073709551615}])", "meshes[0].primitives[1].indices"},
      {"]", R"(,{"attributes":{"POSITION":0},"indices":1,"material":4}])", "primitive 1: material: expected a material below 0"},
      {"]", R"(,{"attributes":{"POSITION":0},"indices":1,"mode":9}])", "primitive 1: mode"},
      {"]", R"(,{"attributes":{"POSITION":1},"indices":1}])", "primitive 1: POSITION"},
      {R"("indices":1)", R"("indices":1.0)", ""},
      {R"("POSITION":0)", R"("POSITION":0,"COLOR_0":1)", "COLOR_0: expected elements of 3 to 4"}};
  for (const auto& [from, to, words] : cases) {
    Parts parts;
    parts.primitives = replaced(parts.primitives, from, to);
    const GltfLevel read = level(parts);
    EXPECT_EQ(read.scene.triangles.size(), 2u) << to;
    expectSays(read, words);
    EXPECT_EQ(read.notes.empty(), std::string(words).empty()) << linesOf(read);
  }
}

TEST_F(GltfStrangers, DataUrisAreThoseOfTheStandard) {
  Parts parts;
  // so that its base64 has + and /
  parts.bin += "\xfb\xef\xbe\xff\xff\xff!";
  std::string codes = base64(parts.bin), safe = codes, encoded, broken_lines, plain;
  for (char& c : safe) c = c == '+' ? '-' : c == '/' ? '_' : c;
  safe.resize(safe.find_last_not_of('=') + 1);
  for (const char c : codes) encoded += c == '+' ? "%2B" : c == '/' ? "%2f" : c == '=' ? "%3D" : std::string(1, c);
  for (size_t i = 0; i < codes.size(); i += 20) broken_lines += codes.substr(i, 20) + R"(\r\n )";
  for (const char c : parts.bin) plain += fmt::format("%{:02X}", static_cast<unsigned char>(c));
  const std::string uris[] = {"data:;base64," + codes,
                              "data:application/octet-stream;charset=utf-8;base64," + codes,
                              "DATA:application/binary;BASE64," + codes,
                              R"(data:a/b;c=\"d,e\";base64,)" + codes,
                              "data:;base64," + safe,
                              "data:;base64," + encoded,
                              "data:;base64," + broken_lines,
                              "data:," + plain};
  for (const std::string& uri : uris) {
    const GltfLevel read = readGltf(write("uri.gltf", parts.json(uri)));
    EXPECT_EQ(areaOf(read.scene), 1.0) << uri;
    EXPECT_TRUE(read.notes.empty()) << linesOf(read);
  }
  for (const char* uri : {"data:;base64", "data:;base64,", "data:;base64,A!AA", "data:;base64,AAAAA", R"(data:a=\",AAAA)"})
    EXPECT_NE(errorOf(parts.json(uri)).find("buffers[0].uri: expected a data URI (RFC 2397)"), std::string::npos) << uri;
}

TEST_F(GltfStrangers, ABrokenBufferIsMissedByWhatUsesItAlone) {
  for (const char* uri : {"data:;base64,A!AA", "nothing.bin", "empty.bin", ""}) {
    Parts parts;
    write("empty.bin", "");
    parts.more_buffers = R"(,{"byteLength":5,"uri":")" + std::string(uri) + "\"}";
    const GltfLevel unused = level(parts);
    EXPECT_EQ(areaOf(unused.scene), 1.0) << uri;
    expectSays(unused, "what lies in it is left out");
    parts.views = replaced(parts.views, "]", R"(,{"buffer":1,"byteLength":48}])");
    parts.accessors = replaced(parts.accessors, "]", R"(,{"bufferView":2,"componentType":5126,"count":4,"type":"VEC3"}])");
    parts.primitives = replaced(parts.primitives, "]", R"(,{"attributes":{"POSITION":2}}])");
    const GltfLevel used = level(parts);
    EXPECT_EQ(areaOf(used.scene), 1.0) << uri;
    expectSays(used, "primitive 1: POSITION: expected buffer view 2 within the buffer's 1 bytes");
  }
  // of a file by its own length
  Parts parts;
  write("longer.bin", parts.bin + "more");
  EXPECT_EQ(areaOf(readGltf(write("file.gltf", parts.json("longer.bin"))).scene), 1.0);
}

// Codes that an exporter forgot to normalise. Each is half of what stands for white, but for the alpha of three.
TEST_F(GltfStrangers, ColoursThatAreNotNormalizedAreTakenAsCodesAndSaid) {
  const auto repeated = [](const std::string& bytes) { return bytes + bytes + bytes + bytes; };
  const auto floats = [&](std::initializer_list<float> colour) { return repeated(bytesOf<float>(colour)); };
  const std::string byte = R"("componentType":5121,"type":"VEC4")", word = R"("componentType":5123,"type":"VEC4")";
  const std::string rgb = R"("componentType":5126,"type":"VEC3")", rgba = R"("componentType":5126,"type":"VEC4")";
  const std::string half_bytes = repeated(bytesOf<uint8_t>({128, 128, 128, 255}));
  const struct {
    std::string bytes, accessor;
    const char* says;
    float least, most;
  } cases[] = {{half_bytes, byte, "taken as of 0 to 255", 0.49f, 0.51f},
               {half_bytes, byte + R"(,"normalized":true)", "", 0.49f, 0.51f},
               {repeated(bytesOf<uint16_t>({32768, 32768, 32768, 65535})), word, "taken as of 0 to 65535", 0.49f, 0.51f},
               {floats({127.5f, 127.5f, 127.5f}), rgb, "taken as of 0 to 255", 0.49f, 0.51f},
               {floats({127.5f, 127.5f, 127.5f, 1.0f}), rgba, "taken as of 0 to 255", 0.49f, 0.51f},
               {floats({-1.0f, 0.5f, 1.0f}), rgb, "COLOR_0: 4 numbers outside of 0 to 1: cut", 0.5f, 0.5f},
               {floats({32767.5f, 32767.5f, 32767.5f, 1.0f}), rgba, "taken as of 0 to 65535", 0.49f, 0.51f},
               {floats({300.0f, 127.5f, 127.5f}), rgb, "COLOR_0: 4 numbers outside of 0 to 255: cut", 0.49f, 0.51f},
               // a single bright vertex
               {floats({0.5f, 0.5f, 0.5f}).substr(12) + bytesOf<float>({9.0f, 0.5f, 9.0f}), rgb,
                "COLOR_0: 2 numbers outside of 0 to 1: cut", 0.5f, 0.5f},
               {floats({1.5f, 0.5f, 1.5f}), rgb, "COLOR_0: 8 numbers outside of 0 to 1: cut", 0.5f, 0.5f},
               {floats({0.5f, 0.5f, 0.5f}), rgb, "", 0.5f, 0.5f}};
  for (const auto& one : cases) {
    Parts parts;
    parts.add(one.bytes, R"("count":4,)" + std::string(one.accessor));
    parts.primitives = replaced(parts.primitives, R"("POSITION":0)", R"("POSITION":0,"COLOR_0":2)");
    const GltfLevel read = level(parts);
    for (const glm::vec4& colour : read.scene.vertex_colours) {
      EXPECT_GE(colour.g, one.least) << one.accessor;
      EXPECT_LE(colour.g, one.most) << one.accessor;
      EXPECT_EQ(colour.a, 1.0f) << one.accessor;
    }
    EXPECT_EQ(read.scene.vertex_colours.size(), 4u) << one.accessor;
    expectSays(read, one.says);
    EXPECT_EQ(read.notes.empty(), one.says[0] == '\0') << linesOf(read);
  }
}

TEST_F(GltfStrangers, NodesMayNestAsDeepAsTheyLike) {
  std::vector<std::string> nodes;
  constexpr int kDepth = 3000;
  for (int i = 0; i < kDepth; ++i) nodes.push_back(R"({"children":[)" + std::to_string(i + 1) + "]}");
  nodes.push_back(R"({"mesh":0,"extensions":{"KHR_lights_punctual":{"light":0}}})");
  Parts parts = nodesOf(nodes);
  parts.scenes = R"([{"nodes":[0]}])";
  parts.more = R"(,"extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","intensity":2}]}})";
  const GltfLevel read = level(parts);
  EXPECT_EQ(read.scene.triangles.size(), 2u);
  EXPECT_EQ(read.scene.light.lamps.size(), 1u);
  EXPECT_TRUE(read.notes.empty()) << linesOf(read);
}

TEST_F(GltfStrangers, ExtrasMayNestAsDeepAsTheyLike) {
  for (const size_t depth : {100u, 200000u}) {
    // {"a":[{"a":[... 1 ...]}]}
    std::string extras, end;
    for (size_t i = 0; i < depth; ++i) extras += R"({"b":2,"a":[)", end += R"(,3],"c":4})";
    const GltfLevel read = level(nodesOf({named("deep", R"(,"extras":)" + extras + "1" + end), named("other")}));
    EXPECT_EQ(namesOf(read.scene), "deep other");
    EXPECT_TRUE(read.notes.empty()) << linesOf(read);
  }
}

TEST_F(GltfStrangers, EmissionAboveOneIsTakenAsItIs) {
  Parts parts;
  parts.primitives = R"([{"attributes":{"POSITION":0},"indices":1,"material":0}])";
  parts.more =
      R"(,"materials":[{"name":"glow","emissiveFactor":[5,4,0],"extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":2}},)"
      R"("pbrMetallicRoughness":{"baseColorFactor":[-1,3,0.5,1]}},{"emissiveFactor":[7,7,7]}])";
  const GltfLevel read = level(parts);
  EXPECT_EQ(read.scene.materials[0].emissive, glm::vec3(10, 8, 0));
  EXPECT_EQ(read.scene.materials[0].base_color, glm::vec3(0, 1, 0.5f));
  expectSays(read, "material glow: emissiveFactor of 5, above 1: taken as it is");
  expectSays(read, "material glow: baseColorFactor of -1 and another one: brought into 0 to 1");
  EXPECT_EQ(read.notes.size(), 2u) << "what nothing uses is not told of: " << linesOf(read);
}

// --- units of exporters

TEST_F(GltfStrangers, TheUnitOfAnExporterIsKnownByItsSign) {
  using Kind = LightUnit::Kind;
  const auto unitOf = [&](const std::string& generator, const std::string& lights) {
    Parts parts;
    parts.more = R"(,"extensions":{"KHR_lights_punctual":{"lights":[)" + lights + "]}}";
    const std::string text = replaced(parts.text(), R"("asset":{)", R"("asset":{"generator":")" + generator + "\",");
    return readGltf(write("unit.gltf", text)).scene.light.unit;
  };
  const struct {
    const char *version, *lights;
    Kind kind;
    const char* sign;
  } cases[] = {{"4.3.47", R"({"type":"point","intensity":217.40565226352905})", Kind::standard, "such as 4 W"},
               {"4.3.47", R"({"type":"point","intensity":2174.0565226352905})", Kind::standard, "such as 40 W"},
               {"4.3.47", R"({"type":"point","intensity":0.3183098861837907})", Kind::same, "such as 4 W"},
               {"4.3.47", R"({"type":"point","intensity":636.6197723675814})", Kind::same, "such as 8000 W"},
               {"4.3.47", R"({"type":"point","intensity":5.4351413})", Kind::standard, "such as 0.1 W"},
               {"4.3.47", R"({"type":"point","intensity":60})", Kind::raw, "such as 60 W"},
               {"4.3.47", R"({"type":"directional","intensity":2049})", Kind::standard, "such as 3 W"},
               {"4.3.47", R"({"type":"directional","intensity":3.5})", Kind::same, "such as 3.5 W"},
               // no digits tell
               {"4.3.47", R"({"type":"point","intensity":163.123457})", Kind::standard, "the exporter's default"},
               {"4.3.47", R"({"type":"point","intensity":16.3123457})", Kind::same, "too faint"},
               {"4.3.47", R"({"type":"directional","intensity":51.23456},{"type":"point","intensity":1.234567})", Kind::standard,
                "default"},
               // exporters from before there were units
               {"3.3.36", R"({"type":"point","intensity":217.40565226352905})", Kind::raw, "exporters before 3.4.40"},
               {"3.4.50", R"({"type":"point","intensity":217.40565226352905})", Kind::standard, "4"},
               {"4.3.47", "", Kind::same, ""}};
  for (const auto& one : cases) {
    const LightUnit unit = unitOf(std::string("Khronos glTF Blender I/O v") + one.version, one.lights);
    EXPECT_EQ(static_cast<int>(unit.kind), static_cast<int>(one.kind)) << one.version << one.lights << unit.sign;
    EXPECT_NE(unit.sign.find(one.sign), std::string::npos) << one.lights << unit.sign;
    EXPECT_EQ(unit.sign.empty(), std::string(one.sign).empty());
  }
  const std::pair<const char*, Kind> engines[] = {
      {"Godot Engine v4.3.stable.official@77dcf97d82cbfe4e4615475fa52ca03da645dbd8", Kind::over_pi},
      {"Unity 2022.3.10f1 glTFast 6.0.1", Kind::unsure},
      {"THREE.GLTFExporter r152", Kind::unsure},
      {"THREE.GLTFExporter", Kind::unsure},
      {"THREE.GLTFExporter r155", Kind::same},
      {"UnityGLTF", Kind::same},
      {"Babylon.js v7.2.0", Kind::same},
      {"babylon.js glTF exporter for 3dsmax 2023", Kind::unsure},
      {"babylon.js glTF exporter for Maya 2022", Kind::unsure},
      {"Unreal Engine 5.3.2", Kind::unsure},
      {"SketchUp 24.0", Kind::unsure},
      {"Houdini", Kind::unsure}};
  for (const auto& [generator, kind] : engines) {
    const LightUnit unit = unitOf(generator, R"({"type":"point","intensity":2})");
    EXPECT_EQ(static_cast<int>(unit.kind), static_cast<int>(kind)) << generator;
    EXPECT_EQ(unit.sign.empty(), kind == Kind::same) << generator;
  }
  Parts others;
  others.more = R"(,"extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","intensity":217.40565}]}})";
  EXPECT_EQ(level(others).scene.light.unit.sign, "");
}

}  // namespace
}  // namespace nlg
