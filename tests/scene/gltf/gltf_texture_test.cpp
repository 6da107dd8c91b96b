// Images, places on them, alpha and the list of what was not read, of glTF files made by hand.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "scene/model/surface_look.h"
#include "tests/scene/gltf/gltf_packed_parts.h"
#include "tests/scene/gltf/gltf_parts.h"
#include "tests/scene/image/hand_built_images.h"

namespace nlg {
namespace {

// Left half red, right half green, in two columns of one row; blue where it is not there.
const std::string kHalves("\xff\0\0\xff\0\xff\0\x40", 8);

// A square whose places on its image run from its lower left corner at (0, 1) to its upper right one at (1, 0), and once more with
// all of them halved as TEXCOORD_1, in normalized integers of 16 bits; then whatever bytes an image is.
Parts texturedSquare(const std::string& material, const std::string& image_bytes) {
  Parts parts;
  parts.add(bytesOf<float>({0, 1, 1, 1, 1, 0, 0, 0}), R"("componentType":5126,"count":4,"type":"VEC2")");
  parts.add(bytesOf<uint16_t>({0, 32768, 32768, 32768, 32768, 0, 0, 0}),
            R"("componentType":5123,"normalized":true,"count":4,"type":"VEC2")");
  parts.add(image_bytes.empty() ? std::string(1, '\0') : image_bytes);
  parts.primitives = R"([{"attributes":{"POSITION":0,"TEXCOORD_0":2,"TEXCOORD_1":3},"indices":1,"material":0}])";
  parts.more =
      R"(,"images":[{"bufferView":4,"mimeType":"image/png","name":"picture"}],"samplers":[{"wrapS":33071,"wrapT":33648}],)"
      R"("textures":[{"source":0},{"source":0,"sampler":0}],"materials":[)" +
      material + "]";
  return parts;
}

std::string baseTexture(const std::string& more = "") {
  return R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0)" + more + "}}}";
}

class GltfTextures : public GltfFiles {
 protected:
  GltfLevel level(const Parts& parts, double dense_transmissive = kDenseTransmissive) const {
    return readGltf(write("textured.gltf", parts.text()), 1.0, dense_transmissive);
  }
  // Places on the base colour's image of the square's corners: lower left, lower right, upper right, upper left.
  void expectPlaces(const Scene& scene, const std::vector<glm::vec2>& expected) const {
    ASSERT_EQ(scene.base_places.size(), expected.size());
    for (size_t i = 0; i < expected.size(); ++i)
      EXPECT_LT(glm::length(scene.base_places[i] - expected[i]), 1e-4f)
          << "corner " << i << ": " << scene.base_places[i].x << " " << scene.base_places[i].y;
  }
  bool hasNote(const GltfLevel& level, const std::string& words) const {
    return std::any_of(level.notes.begin(), level.notes.end(),
                       [&](const std::string& note) { return note.find(words) != std::string::npos; });
  }
};

// of the first triangle (lower left, lower right, upper right): near its lower right corner
glm::vec3 colourAtRight(const Scene& scene) { return baseColourAt(scene, 0, 0.98f, 0.01f); }

TEST_F(GltfTextures, ReadsImagesOfEveryKindFromEveryPlace) {
  const std::string image_of_targa = targa(2, 2, 1, 32, std::string("\0\0\xff\xff\0\xff\0\x40", 8));
  for (const std::string& image : {png(2, 1, kHalves), webp(2, 1, kHalves), image_of_targa}) {
    Parts inside = texturedSquare(baseTexture(), image), uri = inside, beside = inside;
    const std::string entry = R"({"bufferView":4,"mimeType":"image/png","name":"picture"})";
    uri.more = replaced(uri.more, entry, R"({"uri":"data:image/png;base64,)" + base64(image) + R"("})");
    beside.more = replaced(beside.more, entry, R"({"uri":"two%20halves.png"})");
    write("two halves.png", image);
    Parts other_uri = uri;
    other_uri.more = replaced(uri.more, "data:image/png;base64", "DATA:image/webp;BASE64");
    for (const Parts& parts : {inside, uri, other_uri, beside}) {
      const GltfLevel read = level(parts);
      EXPECT_TRUE(read.notes.empty()) << read.notes[0];
      ASSERT_EQ(read.scene.images.size(), 1u);
      EXPECT_EQ(read.scene.materials[0].transmissive, Transmissive::none) << "opaque, whatever its image's alpha";
      // bilinear: red at the left rim's texel and beyond, green at the right one's; wrapped around at the rims themselves
      EXPECT_LT(glm::length(baseColourAt(read.scene, 0, 0.25f, 0.0f) - glm::vec3(1, 0, 0)), 1e-3f);
      EXPECT_LT(glm::length(baseColourAt(read.scene, 0, 0.75f, 0.0f) - glm::vec3(0, 1, 0)), 1e-3f);
    }
  }
}

TEST_F(GltfTextures, AnImageOfOneColourIsTheFactor) {
  const std::string colour("\x20\x80\xe0\xff", 4);
  const glm::vec3 linear(linearFromSrgb(0x20), linearFromSrgb(0x80), linearFromSrgb(0xe0));
  const Scene scene = level(texturedSquare(R"({"emissiveFactor":[1,1,1],"emissiveTexture":{"index":1},)"
                                           R"("pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})",
                                           png(600, 3, pixels(1800, colour))))
                          .scene;
  for (const float u : {0.0f, 0.3f, 0.71f}) {
    EXPECT_EQ(baseColourAt(scene, 1, u, 0.2f), linear);
    EXPECT_EQ(emissionAt(scene, 1, u, 0.2f), linear);
  }
}

TEST_F(GltfTextures, PlacesAreThoseOfTheSetAndItsTransform) {
  const auto transform = [](const std::string& members) {
    return R"(,"extensions":{"KHR_texture_transform":{)" + members + "}}";
  };
  const struct {
    const char* name;
    std::string texture;  // behind "index":0
    std::vector<glm::vec2> places;
  } cases[] = {
      {"first set", "", {{0, 1}, {1, 1}, {1, 0}, {0, 0}}},
      {"second set", R"(,"texCoord":1)", {{0, .5}, {.5, .5}, {.5, 0}, {0, 0}}},
      {"offset and scale", transform(R"("offset":[0.25,-1],"scale":[2,3])"), {{.25, 2}, {2.25, 2}, {2.25, -1}, {.25, -1}}},
      {"another set", transform(R"("texCoord":1)"), {{0, .5}, {.5, .5}, {.5, 0}, {0, 0}}},
      // the specification's example: the lower left quadrant, turned clockwise by a right angle
      {"rotation",
       transform(R"("offset":[0,1],"rotation":1.57079632679,"scale":[0.5,0.5])"),
       {{.5, 1}, {.5, .5}, {0, .5}, {0, 1}}}};
  for (const auto& one : cases) {
    SCOPED_TRACE(one.name);
    const GltfLevel read = level(texturedSquare(baseTexture(one.texture), png(2, 1, kHalves)));
    EXPECT_TRUE(read.notes.empty());
    expectPlaces(read.scene, one.places);
  }
}

TEST_F(GltfTextures, DracoHoldsPlacesAndColours) {
  Parts parts = dracoParts(dracoSquare(draco::MESH_EDGEBREAKER_ENCODING, false, true));
  parts.add(png(2, 1, kHalves));
  parts.accessors = replaced(parts.accessors, R"("type":"SCALAR"})",
                             R"("type":"SCALAR"},{"componentType":5126,"count":4,"type":"VEC2"},)"
                             R"({"componentType":5121,"normalized":true,"count":4,"type":"VEC4"})");
  parts.primitives = replaced(parts.primitives, R"("POSITION":0},"indices":1)",
                              R"("POSITION":0,"TEXCOORD_0":2,"COLOR_0":3,"NORMAL":0},"indices":1,"material":0)");
  parts.primitives = replaced(parts.primitives, R"("attributes":{"POSITION":0}}})",
                              R"("attributes":{"POSITION":0,"TEXCOORD_0":1,"COLOR_0":2}}})");
  parts.more +=
      R"(,"images":[{"bufferView":1,"mimeType":"image/png"}],"textures":[{"source":0}],"materials":[)" + baseTexture() + "]";
  const GltfLevel read = level(parts);
  EXPECT_TRUE(read.notes.empty()) << read.notes[0];
  const Scene& scene = read.scene;
  ASSERT_EQ(scene.base_places.size(), scene.positions.size());
  ASSERT_EQ(scene.vertex_colours.size(), scene.positions.size());
  for (size_t i = 0; i < scene.positions.size(); ++i) {
    const glm::vec2 at(glm::dvec3(scene.positions[i]) + scene.origin_m);
    EXPECT_EQ(scene.base_places[i], at);
    EXPECT_EQ(scene.vertex_colours[i], glm::vec4(at, 0.2f, 1.0f));
  }
}

TEST_F(GltfTextures, SamplersWrap) {
  Parts parts = texturedSquare(replaced(baseTexture(), R"("index":0)", R"("index":1)"), png(2, 1, kHalves));
  const Material material = level(parts).scene.materials.at(0);
  EXPECT_EQ(material.base_image.wrap_u, TextureWrap::clamp);
  EXPECT_EQ(material.base_image.wrap_v, TextureWrap::mirror);
}

TEST_F(GltfTextures, PlacesThatAreMissingAreTheCornerAndNoted) {
  Parts parts = texturedSquare(baseTexture(), png(2, 1, kHalves));
  parts.primitives = R"([{"attributes":{"POSITION":0},"indices":1,"material":0}])";
  const GltfLevel read = level(parts);
  expectPlaces(read.scene, std::vector<glm::vec2>(4, glm::vec2(0.0f)));
  EXPECT_TRUE(hasNote(read, "1 primitives have an image, and not all of their places"));
}

TEST_F(GltfTextures, WhatCannotBeReadIsGreyAndDarkAndNoted) {
  const std::string image = R"({"bufferView":4,"mimeType":"image/png","name":"picture"})";
  const struct {
    const char* name;
    std::string from, to;  // in the root's members
    std::string note;
  } cases[] = {
      {"no image", "", "", "\"picture\", which is of no kind that is read"},
      {"missing", image, R"({"uri":"missing.png"})", "\"missing.png\", which is not there"},
      {"elsewhere", image, R"({"uri":"../secret.png"})", "\"../secret.png\", which lies outside of the scene's folder"},
      {"absolute", image, R"({"uri":"/etc/passwd"})", "\"/etc/passwd\", which lies outside of the scene's folder"},
      {"a link out", image, R"({"uri":"link.png"})", "\"link.png\", which is no file in the scene's folder"},
      {"a folder", image, R"({"uri":"."})", "\".\", which is no file in the scene's folder"},
      {"no base64", image, R"({"uri":"data:image/png;base64,?"})", "\"image 0\", which has a data URI that is none of RFC 2397"},
      {"basisu", R"({"source":0},{"source":0,)", R"({"extensions":{"KHR_texture_basisu":{"source":0}}},{"source":0,)",
       "is of no kind that is read"}};
  write("secret.bin", "");
  std::ofstream(folder_ / "secret.png") << "secret";
  fs::create_symlink(folder_ / "secret.png", folder_ / "level/link.png");
  for (const auto& one : cases) {
    SCOPED_TRACE(one.name);
    Parts parts = texturedSquare(R"({"emissiveFactor":[1,1,1],"emissiveTexture":{"index":0},)"
                                 R"("pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0,1],"baseColorTexture":{"index":0}}})",
                                 "no image at all, but long enough");
    if (!one.from.empty()) parts.more = replaced(parts.more, one.from, one.to);
    const GltfLevel read = level(parts);
    EXPECT_EQ(read.scene.materials.at(0).base_color, glm::vec3(0.5f, 0.25f, 0.0f));
    EXPECT_EQ(read.scene.materials.at(0).emissive, glm::vec3(0.0f));
    ASSERT_EQ(read.notes.size(), 1u);
    EXPECT_NE(read.notes[0].find(one.note), std::string::npos) << read.notes[0];
  }
}

// --- colours of vertices

TEST_F(GltfTextures, VertexColoursTimesBaseColour) {
  Parts parts;
  parts.add(bytesOf<uint8_t>({255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 0, 51, 51, 51, 51}),
            R"("componentType":5121,"normalized":true,"count":4,"type":"VEC4")");
  parts.primitives =
      R"([{"attributes":{"POSITION":0},"indices":1},{"attributes":{"POSITION":0,"COLOR_0":2},"indices":1,"material":0}])";
  parts.nodes = R"([{"mesh":0},{"mesh":0,"translation":[3,0,0]}])";
  parts.scenes = R"([{"nodes":[0,1]}])";
  parts.more = R"(,"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.5,1,1,1]}}])";
  const Scene scene = level(parts).scene;
  ASSERT_EQ(scene.vertex_colours.size(), 16u);
  for (const size_t first : {size_t{0}, size_t{8}}) {
    EXPECT_EQ(scene.vertex_colours[first], glm::vec4(1.0f)) << "a primitive without";
    EXPECT_EQ(scene.vertex_colours[first + 4], glm::vec4(1, 0, 0, 1));
    EXPECT_EQ(scene.vertex_colours[first + 7], glm::vec4(0.2f, 0.2f, 0.2f, 1.0f)) << "opaque: alpha is nothing";
  }
  EXPECT_EQ(baseColourAt(scene, 2, 0.0f, 0.0f), glm::vec3(0.5f, 0, 0));
  parts.bin.replace(60, 16, std::string(16, '\xff'));
  EXPECT_TRUE(level(parts).scene.vertex_colours.empty()) << "all white";
}

// --- alpha

TEST_F(GltfTextures, AlphaAndTransmissionMakeTransmissiveSurfaces) {
  // opacities of 64, 127, 128 and 255
  const std::string white("\xff\xff\xff", 3);
  const std::string rgba = white + "\x40" + white + "\x7f" + white + "\x80" + white + "\xff";
  const std::string textured = R"("pbrMetallicRoughness":{"baseColorTexture":{"index":0}})";
  const auto factor = [](const char* alpha) {
    return R"("pbrMetallicRoughness":{"baseColorFactor":[1,1,1,)" + std::string(alpha) + "]}";
  };
  const auto transmission = [](const std::string& members) {
    return R"("extensions":{"KHR_materials_transmission":{)" + members + "}}";
  };
  const std::string twice_as_strict = R"("pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.5],"baseColorTexture":{"index":0}})";
  const struct {
    const char* name;
    std::string material, rgba;  // of an image of four columns
    Transmissive transmissive;
    double stops;  // the share of light
  } cases[] = {
      {"opaque", "{" + textured + "}", rgba, Transmissive::none, 1.0},
      {"cut", R"({"alphaMode":"MASK",)" + textured + "}", rgba, Transmissive::dense, 0.5},
      {"cut high", R"({"alphaMode":"MASK","alphaCutoff":0.9,)" + textured + "}", rgba, Transmissive::thin, 0.25},
      {"cut by the product", R"({"alphaMode":"MASK",)" + twice_as_strict + "}", rgba, Transmissive::thin, 0.25},
      {"cut at nothing", R"({"alphaMode":"MASK","alphaCutoff":0,)" + textured + "}", rgba, Transmissive::none, 1.0},
      {"cut whole", R"({"alphaMode":"MASK","alphaCutoff":1.5,)" + textured + "}", rgba, Transmissive::thin, 0.0},
      {"cut without an image", R"({"alphaMode":"MASK",)" + factor("0.3") + "}", rgba, Transmissive::thin, 0.0},
      {"cut, and all there", R"({"alphaMode":"MASK",)" + factor("0.7") + "}", rgba, Transmissive::none, 1.0},
      {"blended", R"({"alphaMode":"BLEND",)" + textured + "}", rgba, Transmissive::dense, (64 + 127 + 128 + 255) / 1020.0},
      {"a pane", R"({"alphaMode":"BLEND",)" + factor("0.15") + "}", rgba, Transmissive::thin, 0.15},
      {"blends nothing", R"({"alphaMode":"BLEND",)" + factor("1") + "}", rgba, Transmissive::none, 1.0},
      {"glass", "{" + transmission(R"("transmissionFactor":0.9)") + "}", rgba, Transmissive::thin, 0.1},
      {"glass in part", "{" + transmission(R"("transmissionFactor":0.9,"transmissionTexture":{"index":0})") + "}",
       pixels(2, std::string("\0\0\0\xff", 4)) + pixels(2, "\xff\xff\xff\xff"), Transmissive::dense, 0.55},
      {"no glass", "{" + transmission(R"("transmissionFactor":0)") + "}", rgba, Transmissive::none, 1.0}};
  for (const auto& one : cases) {
    SCOPED_TRACE(one.name);
    const GltfLevel read = level(texturedSquare(one.material, png(4, 1, one.rgba)));
    const Material& material = read.scene.materials.at(0);
    EXPECT_EQ(static_cast<int>(material.transmissive), static_cast<int>(one.transmissive));
    EXPECT_EQ(material.double_sided, one.transmissive != Transmissive::none);
    const bool uses_image = std::string(one.material).find("index") != std::string::npos;
    const size_t unused_images = uses_image ? 0 : 1;
    ASSERT_EQ(read.notes.size(), unused_images + (one.transmissive == Transmissive::none ? 0 : 1));
    // bilinear over four texels: what stands at a texel's middle holds there, and the mean holds
    double stopped = 0.0;
    for (const float u : {0.125f, 0.375f, 0.625f, 0.875f}) stopped += 0.25 * stoppedAt(read.scene, 0, u, 0.0f);
    EXPECT_NEAR(stopped, one.stops, 0.003);
    if (one.transmissive == Transmissive::none) continue;
    const std::string words = fmt::format("1 material lets light through: material 0 ({}, stops {:.0f} %)",
                                          one.transmissive == Transmissive::thin ? "thin" : "dense", 100.0 * one.stops);
    EXPECT_EQ(read.notes[0], words);
  }
}

TEST_F(GltfTextures, UnlitShinesNot) {
  const Parts parts = texturedSquare(R"({"emissiveFactor":[1,1,1],"extensions":{"KHR_materials_unlit":{}},)"
                                     R"("pbrMetallicRoughness":{"baseColorFactor":[0.25,1,1,1]}})",
                                     "");
  const Material material = level(parts).scene.materials.at(0);
  EXPECT_EQ(material.emissive, glm::vec3(0.0f));
  EXPECT_EQ(material.base_color, glm::vec3(0.25f, 1, 1));
}

TEST_F(GltfTextures, DiffuseOfSpecularGlossinessIsBaseColour) {
  const Parts parts = texturedSquare(
      R"({"extensions":{"KHR_materials_pbrSpecularGlossiness":{"diffuseFactor":[0.5,1,1,1],"diffuseTexture":{"index":0}}}})",
      png(2, 1, kHalves));
  const Scene scene = level(parts).scene;
  EXPECT_EQ(scene.materials.at(0).base_color, glm::vec3(0.5f, 1, 1));
  EXPECT_GT(colourAtRight(scene).g, 0.4f);
}

}  // namespace
}  // namespace nlg
