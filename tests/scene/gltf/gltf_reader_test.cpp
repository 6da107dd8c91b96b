#include "tests/scene/gltf/gltf_parts.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "scene/gltf/gltf_light.h"
#include "scene/lights/light_groups.h"
#include "tool/error.h"

namespace nlg {
namespace {

using GltfReader = GltfFiles;

TEST_F(GltfReader, ReadsASquareFromADataUri) {
  const Scene scene = read({});
  EXPECT_EQ(scene.id, "test");
  ASSERT_EQ(scene.triangles.size(), 2u);
  EXPECT_EQ(scene.positions.size(), 4u);
  ASSERT_EQ(scene.objects.size(), 1u);
  EXPECT_EQ(scene.objects[0].name, "square");
  EXPECT_EQ(scene.objects[0].triangle_count, 2u);
  expectNear(normalOf(scene, 0), {0, 0, 1}, "normal");
}

TEST_F(GltfReader, ReadsTheSameFromGlbAndFromABinBeside) {
  const Parts parts;
  write("my square.bin", parts.bin);
  const Scene expected = read(parts);
  const Scene glb = readGltf(write("test.glb", parts.binary())).scene;
  const Scene beside = readGltf(write("beside.gltf", parts.json("my%20square.bin"))).scene;
  EXPECT_EQ(glb.positions, expected.positions);
  EXPECT_EQ(glb.triangles, expected.triangles);
  EXPECT_EQ(beside.positions, expected.positions);
}

TEST_F(GltfReader, ReadsIndicesOf8And32BitsAndNone) {
  const std::pair<const char*, std::string> cases[] = {{"5121", bytesOf<uint8_t>({0, 1, 2, 0, 2, 3})},
                                                       {"5125", bytesOf<uint32_t>({0, 1, 2, 0, 2, 3})}};
  for (const auto& [type, indices] : cases) {
    Parts parts;
    parts.bin = kSquare.substr(0, 48) + indices;
    parts.views = replaced(parts.views, R"("byteLength":12)", R"("byteLength":)" + std::to_string(indices.size()));
    parts.accessors = replaced(parts.accessors, "5123", type);
    EXPECT_DOUBLE_EQ(areaOf(read(parts)), 1.0);
  }

  Parts none;
  none.primitives = R"([{"attributes":{"POSITION":0}}])";
  none.accessors = replaced(none.accessors, R"("count":4)", R"("count":3)");
  EXPECT_DOUBLE_EQ(areaOf(read(none)), 0.5);
}

TEST_F(GltfReader, ReadsStripsAndFansWithAllFrontsOneWay) {
  Parts fan;
  fan.primitives = R"([{"attributes":{"POSITION":0},"mode":6}])";
  Parts strip;
  strip.bin = bytesOf<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}) + kSquare.substr(48);
  strip.primitives = R"([{"attributes":{"POSITION":0},"mode":5}])";
  for (const Parts& parts : {fan, strip}) {
    const Scene scene = read(parts);
    ASSERT_EQ(scene.triangles.size(), 2u);
    for (size_t i = 0; i < 2; ++i) expectNear(normalOf(scene, i), {0, 0, 1}, "triangle " + std::to_string(i));
  }
}

TEST_F(GltfReader, SkipsPointsAndLines) {
  Parts parts;
  parts.primitives =
      R"([{"attributes":{"POSITION":0},"mode":0},{"attributes":{"POSITION":0},"mode":1},{"attributes":{"POSITION":0},"indices":1}])";
  EXPECT_EQ(read(parts).triangles.size(), 2u);
}

TEST_F(GltfReader, ReadsInterleavedPositions) {
  Parts parts;
  parts.bin = bytesOf<float>({0, 0, 0, 9, 1, 0, 0, 9, 1, 1, 0, 9, 0, 1, 0, 9}) + kSquare.substr(48);
  parts.views = R"([{"buffer":0,"byteLength":64,"byteStride":16},{"buffer":0,"byteOffset":64,"byteLength":12}])";
  EXPECT_DOUBLE_EQ(areaOf(read(parts)), 1.0);
}

TEST_F(GltfReader, AppliesTransformsFromTheRootDown) {
  Parts parts;
  // scaled by 2, turned a quarter about z (x becomes y), shifted; under a parent that shifts along x
  parts.nodes = R"([{"children":[1],"translation":[10,0,0]},)"
                R"({"mesh":0,"translation":[0,0,5],"rotation":[0,0,0.70710678118654752,0.70710678118654752],"scale":[2,2,2]}])";
  const Scene scene = read(parts);
  expectNear(corner(scene, 0, 0), {10, 0, 5}, "first corner");
  expectNear(corner(scene, 0, 1), {10, 2, 5}, "second corner");
  expectNear(corner(scene, 0, 2), {8, 2, 5}, "third corner");

  parts.nodes = R"([{"mesh":0,"matrix":[0,2,0,0, -2,0,0,0, 0,0,2,0, 10,0,5,1]}])";
  const Scene same = read(parts);
  for (int i = 0; i < 3; ++i) expectNear(corner(same, 0, i), corner(scene, 0, i), "matrix, corner " + std::to_string(i));
}

TEST_F(GltfReader, KeepsFrontsUnderNegativeScale) {
  Parts parts;
  parts.nodes = R"([{"mesh":0,"scale":[-1,1,1]}])";
  const Scene scene = read(parts);
  for (size_t i = 0; i < 2; ++i) expectNear(normalOf(scene, i), {0, 0, 1}, "triangle " + std::to_string(i));
  expectNear(corner(scene, 0, 0), {0, 0, 0}, "first corner");
  EXPECT_DOUBLE_EQ(scene.origin_m.x + sceneBounds(scene).min.x, -1.0);
}

TEST_F(GltfReader, CopiesInstances) {
  Parts parts;
  parts.nodes = R"([{"mesh":0},{"mesh":0,"translation":[4,0,0]},{"mesh":0,"translation":[8,0,0]}])";
  parts.scenes = R"([{"nodes":[0,1,2]}])";
  const Scene scene = read(parts);
  EXPECT_EQ(scene.triangles.size(), 6u);
  ASSERT_EQ(scene.objects.size(), 3u);
  EXPECT_EQ(scene.objects[2].first_triangle, 4u);
  EXPECT_EQ(scene.objects[2].name, "node 2");
}

TEST_F(GltfReader, TakesTheDefaultSceneElseTheFirstElseAllRoots) {
  Parts parts;
  parts.nodes = R"([{"mesh":0},{"mesh":0,"translation":[4,0,0]}])";
  parts.scenes = R"([{"nodes":[0]},{"nodes":[0,1]}])";
  EXPECT_EQ(read(parts).objects.size(), 1u);
  parts.more = R"(,"scene":1)";
  EXPECT_EQ(read(parts).objects.size(), 2u);
  parts.more = "";
  parts.scenes = "[]";
  EXPECT_EQ(read(parts).objects.size(), 2u);
}

TEST_F(GltfReader, LosesNoPrecisionFarFromTheOrigin) {
  Parts parts;
  parts.nodes = R"([{"mesh":0,"translation":[100000.125,0,-250000.25],"scale":[0.001,0.001,0.001]}])";
  const Scene scene = read(parts);
  // a square of one millimetre, 270 km away
  EXPECT_NEAR(areaOf(scene), 1e-6, 1e-9);
  EXPECT_NEAR(corner(scene, 0, 0).x, 100000.125, 1e-7);
}

TEST_F(GltfReader, AppliesSparseAccessors) {
  Parts parts;
  // the third corner is replaced; then all four come from nothing but the sparse values
  parts.add(bytesOf<uint16_t>({2, 0}));
  parts.add(bytesOf<float>({3, 3, 0}));
  parts.accessors =
      replaced(parts.accessors, R"("VEC3")",
               R"("VEC3","sparse":{"count":1,"indices":{"bufferView":2,"componentType":5123},"values":{"bufferView":3}})");
  const Scene scene = read(parts);
  expectNear(corner(scene, 0, 2), {3, 3, 0}, "replaced corner");
  expectNear(corner(scene, 0, 1), {1, 0, 0}, "corner that stays");

  parts.accessors = replaced(parts.accessors, R"("bufferView":0,"componentType":5126)", R"("componentType":5126)");
  const Scene zeros = read(parts);
  EXPECT_EQ(zeros.triangles.size(), 0u);
  EXPECT_EQ(zeros.dropped_triangle_count, 2u);
  EXPECT_TRUE(zeros.objects.empty());
}

// The square again, its corners in integers; by KHR_mesh_quantization a value c of b bits, normalized, is c / (2^b - 1), or
// max(c / (2^(b-1) - 1), -1) where it has a sign.
TEST_F(GltfReader, ReadsQuantizedPositions) {
  const struct {
    const char* type;
    size_t byte_count;
    bool is_signed;
  } types[] = {{"5120", 1, true}, {"5121", 1, false}, {"5122", 2, true}, {"5123", 2, false}};
  for (int k = 0; k < 8; ++k) {
    const auto& [type, byte_count, is_signed] = types[k / 2];
    const bool is_normalized = k % 2 == 1;
    const int half = 1 << (8 * byte_count - 1);
    const auto code = [count = byte_count](int value) { return bytesOf<int32_t>({value}).substr(0, count); };
    // a component that is one, one that is zero, and the type's smallest
    const std::string one = code(!is_normalized ? 1 : is_signed ? half - 1 : 2 * half - 1), zero = code(0);
    const std::string smallest = code(is_signed ? -half : 0);
    const double low_is = !is_signed ? 0.0 : is_normalized ? -1.0 : -half;
    const std::string name = std::string(type) + (is_normalized ? " normalized" : "");
    Parts parts;
    const std::string pad(4 - 3 * one.size() % 4, '\0');  // elements at multiples of four bytes
    const std::string low = zero + smallest + zero;
    parts.bin = low + pad + one + low.substr(zero.size()) + pad + one + one + zero + pad + zero + one + zero + pad +
                bytesOf<uint16_t>({0, 1, 2, 0, 2, 3});
    const std::string stride = std::to_string(3 * one.size() + pad.size());
    const std::string size = std::to_string(parts.bin.size() - 12);
    parts.views = R"([{"buffer":0,"byteStride":)" + stride + R"(,"byteLength":)" + size + R"(},{"buffer":0,"byteOffset":)" +
                  size + R"(,"byteLength":12}])";
    parts.accessors = replaced(parts.accessors, "5126", std::string(type) + (is_normalized ? R"(,"normalized":true)" : ""));
    EXPECT_NE(errorOf(parts.text()).find("expected FLOAT VEC3"), std::string::npos) << name << " without the extension";
    parts.more = R"(,"extensionsUsed":["KHR_mesh_quantization"],"extensionsRequired":["KHR_mesh_quantization"])";
    const Scene scene = read(parts);
    ASSERT_EQ(scene.triangles.size(), 2u) << name;
    expectNear(corner(scene, 0, 0), {0, low_is, 0}, name);
    expectNear(corner(scene, 0, 1), {1, low_is, 0}, name);
    expectNear(corner(scene, 0, 2), {1, 1, 0}, name);
    expectNear(corner(scene, 1, 2), {0, 1, 0}, name);
    EXPECT_NE(errorOf(replaced(parts.text(), R"("count":4)", R"("count":5)")).find("POSITION"), std::string::npos) << name;
    EXPECT_NE(errorOf(replaced(parts.text(), type, "5125")).find("expected VEC3 of FLOAT or integers"), std::string::npos)
        << name;
  }
}

TEST_F(GltfReader, ScalesByTheUnit) {
  Parts parts;
  parts.nodes = R"([{"mesh":0,"translation":[100,200,0],"scale":[3,1,1]},{"camera":0,"translation":[0,0,8]},)"
                R"({"translation":[4,0,0],"extensions":{"KHR_lights_punctual":{"light":0}}}])";
  parts.scenes = R"([{"nodes":[0,1,2]}])";
  parts.more = R"(,"cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":0.1}}],)"
               R"("extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","intensity":5}]}})";
  const std::string path = write("units.gltf", parts.text());
  const Scene metres = readGltf(path).scene, quarters = readGltf(path, 0.25).scene;
  expectNear(corner(quarters, 0, 0), {25, 50, 0}, "corner");
  expectNear(corner(quarters, 0, 2), {25.75, 50.25, 0}, "corner");
  EXPECT_NEAR(areaOf(quarters), areaOf(metres) / 16, 1e-6);
  ASSERT_EQ(quarters.viewpoints.size(), 1u);
  expectNear(quarters.origin_m + glm::dvec3(quarters.viewpoints[0].position), {0, 0, 2}, "camera");
  expectNear(quarters.viewpoints[0].forward, {0, 0, -1}, "camera's direction");
  ASSERT_EQ(quarters.light.lamps.size(), 1u);
  expectNear(quarters.origin_m + glm::dvec3(quarters.light.lamps[0].position), {1, 0, 0}, "lamp");
  EXPECT_EQ(quarters.light.lamps[0].intensity, metres.light.lamps[0].intensity);
}

TEST_F(GltfReader, ReadsMaterials) {
  Parts parts;
  parts.primitives = R"([{"attributes":{"POSITION":0},"indices":1,"material":1},{"attributes":{"POSITION":0},"indices":1}])";
  parts.more = R"(,"extensionsUsed":["KHR_materials_emissive_strength"],"materials":[{},{"doubleSided":true,)"
               R"("pbrMetallicRoughness":{"baseColorFactor":[0.25,0.5,0.75,1]},"emissiveFactor":[1,0.5,0],)"
               R"("extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":8}}}])";
  const Scene scene = read(parts);
  ASSERT_EQ(scene.materials.size(), 3u);
  const Material& lamp = scene.materials[scene.triangle_material[0]];
  EXPECT_EQ(lamp.base_color, glm::vec3(0.25f, 0.5f, 0.75f));
  EXPECT_EQ(lamp.emissive, glm::vec3(8.0f, 4.0f, 0.0f));
  EXPECT_TRUE(lamp.double_sided);
  const Material& standard = scene.materials[scene.triangle_material[2]];
  EXPECT_EQ(standard.base_color, glm::vec3(1.0f));
  EXPECT_FALSE(standard.double_sided);
}

const char* const kLights = R"(,"extensionsUsed":["KHR_lights_punctual"],"extensions":{"KHR_lights_punctual":{"lights":[
  {"type":"point","color":[1,0.5,0],"intensity":40,"range":3},
  {"type":"spot","intensity":10,"spot":{"innerConeAngle":0.25,"outerConeAngle":0.5}},
  {"type":"directional","color":[0.5,0.5,0.5],"intensity":8}]}})";

TEST_F(GltfReader, PutsLightsIntoTheGroupsOfTheirExtras) {
  Parts parts;
  parts.nodes = R"([{"mesh":0},
    {"name":"Sconce","extras":{"light_group":"corridor"},"extensions":{"KHR_lights_punctual":{"light":0}}},
    {"name":"Bulb.002","extensions":{"KHR_lights_punctual":{"light":0}}},
    {"extensions":{"KHR_lights_punctual":{"light":1}}}])";
  parts.scenes = R"([{"nodes":[0,1,2,3]}])";
  parts.more = R"(,"extensionsUsed":["KHR_lights_punctual"],"extensions":{"KHR_lights_punctual":{"lights":[
    {"type":"point","name":"of all bulbs"},{"type":"directional","name":"Noon","extras":{"light_group":"day"}}]}})";
  Scene scene = read(parts);
  groupLights("name", "", &scene);
  EXPECT_EQ(scene.light.groups.names, (std::vector<std::string>{"day", "corridor", "Bulb"}));
  // a mesh has its lights by its materials
  parts.nodes = R"([{"mesh":0,"name":"panel","extras":{"light_group":"screens"}}])";
  parts.scenes = R"([{"nodes":[0]}])";
  const std::vector<std::string> notes = readGltf(write("panel.gltf", parts.text())).notes;
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("panel: light_group of a mesh"), std::string::npos) << notes[0];
}

TEST_F(GltfReader, ReadsLightsWhereTheirNodesStand) {
  Parts parts;
  parts.more = kLights;
  // a parent 1000 km away; its children look along its -z, turned a quarter about x: down
  parts.nodes = R"([{"mesh":0,"translation":[1e6,0,0]},
    {"translation":[1e6,2,3],"rotation":[-0.70710678118,0,0,0.70710678118],"scale":[3,3,3],"children":[2,3,4]},
    {"translation":[1,0,0],"extensions":{"KHR_lights_punctual":{"light":0}}},
    {"extensions":{"KHR_lights_punctual":{"light":1}}},
    {"extensions":{"KHR_lights_punctual":{"light":2}}}])";
  parts.scenes = R"([{"nodes":[0,1]}])";
  const Scene scene = read(parts);
  ASSERT_EQ(scene.light.lamps.size(), 2u);
  const Lamp &point = scene.light.lamps[0], &spot = scene.light.lamps[1];
  EXPECT_EQ(point.intensity, glm::vec3(40, 20, 0));
  EXPECT_EQ(point.radius_m, kGltfLampRadius_m);
  EXPECT_LE(point.cos_outer, -1.0f);
  expectNear(scene.origin_m + glm::dvec3(point.position), {1e6 + 3, 2, 3}, "the point's place");
  EXPECT_EQ(spot.intensity, glm::vec3(10.0f));
  EXPECT_NEAR(spot.cos_inner, std::cos(0.25f), 1e-6f);
  EXPECT_NEAR(spot.cos_outer, std::cos(0.5f), 1e-6f);
  expectNear(glm::dvec3(spot.direction), {0, -1, 0}, "where the spot points");
  ASSERT_EQ(scene.light.suns.size(), 1u);
  EXPECT_EQ(scene.light.suns[0].irradiance, glm::vec3(4.0f));
  expectNear(glm::dvec3(scene.light.suns[0].to_sun), {0, 1, 0}, "where the sun stands");
  EXPECT_TRUE(read(Parts{}).light.lamps.empty());
}

// Each light on a node of its own; by the second node's scale.
Parts lightsOnNodes(const std::string& lights, const std::string& scale = "[1,1,1]") {
  Parts parts;
  parts.more = replaced(lights, R"(,"range":3)", "");  // which has a note of its own
  const auto node = [](const char* idx) { return std::string(R"({"extensions":{"KHR_lights_punctual":{"light":)") + idx + "}}"; };
  parts.nodes = R"([{"mesh":0},)" + node("0") + "}," + node("1") + R"(,"scale":)" + scale + "}," + node("2") + "}]";
  parts.scenes = R"([{"nodes":[0,1,2,3]}])";
  return parts;
}

const char* const kCameras = R"(,"cameras":[{"type":"perspective","name":"wide","perspective":{"yfov":1.5,"znear":0.1}},
  {"type":"orthographic","orthographic":{"xmag":1,"ymag":1,"znear":0.1,"zfar":9}}])";

TEST_F(GltfReader, ReadsCamerasWhereTheirNodesStand) {
  Parts parts;
  parts.more = kCameras;
  // far away, twice as large, turned a quarter about x: a camera that looked along -z looks down, its top towards -z
  parts.nodes = R"([{"mesh":0,"translation":[1e6,0,0]},{"camera":1},
    {"translation":[1e6,2,3],"rotation":[-0.70710678118,0,0,0.70710678118],"scale":[2,2,2],"camera":0}])";
  parts.scenes = R"([{"nodes":[0,1,2]}])";
  const Scene scene = read(parts);
  ASSERT_EQ(scene.viewpoints.size(), 1u);
  const Viewpoint& camera = scene.viewpoints[0];
  EXPECT_EQ(camera.name, "wide");
  EXPECT_EQ(camera.fov_y, 1.5f);
  expectNear(scene.origin_m + glm::dvec3(camera.position), {1e6, 2, 3}, "the camera's place");
  expectNear(glm::dvec3(camera.forward), {0, -1, 0}, "where it looks");
  expectNear(glm::dvec3(camera.up), {0, 0, -1}, "its top");
}

TEST_F(GltfReader, LeavesLightsOutThatCannotBeMendedAndNamesThem) {
  const struct {
    const char *from, *to, *note;
    size_t lamps, suns;
  } cases[] = {{R"("type":"point")", R"("type":"area")", "light 0: a type that is none", 1, 1},
               {"[1,0.5,0]", "[1,0.5,-1]", "light 0: light below 0", 1, 1},
               {R"("intensity":8)", R"("intensity":-8)", "light 2: light below 0", 2, 0},
               {R"("innerConeAngle":0.25,"outerConeAngle":0.5)", R"("outerConeAngle":0)",
                "light 1: a spot's outer cone that is empty", 1, 1}};
  for (const auto& odd : cases) {
    const GltfLevel level = readGltf(write("odd.gltf", lightsOnNodes(replaced(kLights, odd.from, odd.to)).text()));
    ASSERT_EQ(level.notes.size(), 1u) << odd.note;
    EXPECT_EQ(level.notes[0].find(odd.note), 0u) << level.notes[0];
    EXPECT_EQ(level.scene.light.lamps.size(), odd.lamps) << odd.note;
    EXPECT_EQ(level.scene.light.suns.size(), odd.suns) << odd.note;
  }
  const GltfLevel flat = readGltf(write("flat.gltf", lightsOnNodes(kLights, "[0,0,0]").text()));
  ASSERT_EQ(flat.notes.size(), 1u);
  EXPECT_NE(flat.notes[0].find("node 2: a light that points nowhere"), std::string::npos) << flat.notes[0];
  EXPECT_EQ(flat.scene.light.lamps.size(), 1u);
}

TEST_F(GltfReader, DropsAndCountsFlatTriangles) {
  Parts parts;
  parts.bin = kSquare.substr(0, 48) + bytesOf<uint16_t>({0, 1, 2, 0, 2, 2});
  const Scene scene = read(parts);
  EXPECT_EQ(scene.triangles.size(), 1u);
  EXPECT_EQ(scene.dropped_triangle_count, 1u);
  EXPECT_EQ(scene.objects[0].triangle_count, 1u);
}

TEST_F(GltfReader, RefusesBuffersOutsideTheFolder) {
  const Parts parts;
  std::ofstream(folder_ / "secret.bin", std::ios::binary) << parts.bin;
  fs::create_symlink(folder_ / "secret.bin", folder_ / "level/link.bin");
  const std::string absolute = folder_ / "secret.bin";
  for (const std::string& uri :
       {std::string("../secret.bin"), std::string("%2e%2e/secret.bin"), std::string("..%2Fsecret.bin"),
        std::string("a/../../secret.bin"), absolute, "file://" + absolute, std::string("link.bin"),
        std::string("..\\\\secret.bin"), std::string("\\u002e./secret.bin"), std::string("x%00.bin"),
        std::string("http://a/b.bin"), std::string("missing.bin"), std::string("x%zz.bin"), std::string(".")}) {
    const std::string error = errorOf(parts.json(uri));
    EXPECT_NE(error.find("buffer"), std::string::npos) << uri << ": " << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << uri << ": " << error;
  }
}

TEST_F(GltfReader, RefusesAMissingFileAndAFolder) {
  EXPECT_THROW(readGltf(folder_ / "nothing.glb"), InputError);
  EXPECT_THROW(readGltf(folder_.string()), InputError);
}

// Each is the square with one thing replaced: one of each check. gltf_strangers_test.cpp has parts that are left out alone,
// tests/fuzz numbers that reach too far.
const struct {
  const char *name, *from, *to;
  const char* place;  // what the error must name
} kHostile[] = {
    {"position of 16 bits", "5126", "5123", "mesh 0, primitive 0: POSITION"},
    {"float indices", "5123", "5126", "mesh 0, primitive 0: indices"},
    {"accessor past the view", R"("count":4)", R"("count":5)", "mesh 0, primitive 0: POSITION"},
    {"fewer vertices than indexed", R"("count":4)", R"("count":3)", "mesh 0, primitive 0: indices"},
    {"corners not in threes", R"("count":6)", R"("count":5)", "mesh 0, primitive 0: 5 corners"},
    {"view of no buffer", R"({"buffer":0,"byteLength":48})", R"({"buffer":3,"byteLength":48})",
     "bufferViews[0]: expected all members that glTF requires"},
    {"stride below the element", R"("byteLength":48})", R"("byteLength":48,"byteStride":4})", "mesh 0, primitive 0: POSITION"},
    {"index of 33 bits", R"("POSITION":0)", R"("POSITION":4294967296)", "meshes[0].primitives[0].attributes.POSITION"},
    {"mesh as a fraction", R"("mesh":0)", R"("mesh":0.5)", "nodes[0].mesh"},
    {"node that is its own child", R"("mesh":0)", R"("mesh":0,"children":[0])", "node 0"},
    {"child as text", R"("mesh":0)", R"("mesh":0,"children":["a"])", "nodes[0].children[0]"},
    {"infinite translation", R"("mesh":0)", R"("mesh":0,"translation":[1e999,0,0])", "hostile.gltf"},
    {"scale that overflows", R"("mesh":0)", R"("mesh":0,"scale":[1e308,1e308,1e308],"translation":[1e308,0,0])", "node 0"},
    {"matrix of 15", R"("mesh":0)", R"("mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0])", "nodes[0].matrix"},
    {"projective matrix", R"("mesh":0)", R"("mesh":0,"matrix":[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1])", "node 0: matrix"},
    {"nodes that are no list", R"("nodes":[{"mesh":0,"name":"square"}])", R"("nodes":5)", "nodes"},
    {"no such scene", R"("scenes":)", R"("scene":3,"scenes":)", "scene"},
    {"required extension", R"("asset":)", R"("extensionsRequired":["KHR_texture_basisu","XYZ_packed"],"asset":)",
     "extensionsRequired[1]: expected "},
    {"required extension before what it provides", R"("buffers":[)",
     R"("extensionsRequired":["XYZ_packed"],"buffers":[{"byteLength":60},)", "got XYZ_packed"},
    {"key twice", R"("mesh":0)", R"("mesh":0,"mesh":0)", "key \"mesh\""},
    {"buffer without uri", R"("buffers":[)", R"("buffers":[{"byteLength":60},)", "buffer view 0 within the buffer's 1 bytes"},
    {"buffer of another length", R"("byteLength":60)", R"("byteLength":61)", "hostile.gltf"},
    {"wrong version", R"("asset":{"version":"2.0"})", R"("asset":{})", "hostile.gltf"},
};

TEST_F(GltfReader, NamesThePlaceOfWhatIsHostile) {
  for (const auto& hostile : kHostile) {
    const std::string error = saidOf(replaced(Parts().text(), hostile.from, hostile.to));
    EXPECT_NE(error.find(hostile.place), std::string::npos) << hostile.name << ": " << error;
    EXPECT_NE(error.find("hostile.gltf: "), std::string::npos) << hostile.name << ": " << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << hostile.name << ": " << error;
    EXPECT_LT(error.size(), 600u) << hostile.name;
  }
}

}  // namespace
}  // namespace nlg
