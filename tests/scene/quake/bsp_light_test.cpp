#include "scene/quake/bsp_light.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "hand_built_bsp.h"
#include "scene/jitter.h"
#include "scene/model/surface_look.h"
#include "scene/quake/bsp_reader.h"
#include "tests/input_error.h"
#include "tests/scene/image/hand_built_images.h"
#include "tests/scene/scene_triangles.h"

namespace nlg {
namespace {

constexpr uint32_t kSkyFlag = 0x4, kLavaFlag = 0x8;  // of surfaces, of contents

constexpr float kOfCode = 4.0f / 255.0f;
constexpr float kPi = 3.14159265f;

// The floor of smallLevel has a lightmap, its pipe is lit by vertex.
BspParts litLevel() {
  BspParts parts = smallLevel();
  parts.addLightmap();
  parts.faces[0].lightmap = 0;
  const glm::vec2 corners[] = {{0, 0}, {0, 1}, {1, 1}, {1, 0}};
  for (size_t i = 0; i < 4; ++i) parts.lightVertex(i, corners[i], 10, 20, 30);
  // control points of the pipe, three in a row: red rises along it, green along the curve
  for (size_t i = 0; i < 9; ++i)
    parts.lightVertex(4 + i, {}, static_cast<uint8_t>(40 * (i / 3)), static_cast<uint8_t>(100 * (i % 3)), 0);
  return parts;
}

// The same under a sky, seen from below: clockwise from there.
BspParts levelWithSky() {
  BspParts parts = litLevel();
  parts.shaders.push_back({"textures/skies/blue", kSkyFlag, 0});
  parts.addFace(1, 1, {{0, 0, 1000}, {100, 0, 1000}, {100, 100, 1000}, {0, 100, 1000}});
  return parts;
}

class BspLight : public testing::Test {
 protected:
  BspLevel read(const BspParts& parts) const { return readBsp(folder_.write("level.bsp", parts.bytes())); }
  TemporaryFolder folder_;
};

TEST_F(BspLight, LightmapsAndVerticesAreFourTimesTheirCodesOver255) {
  const Scene scene = read(litLevel()).scene;
  const BakedLight& baked = scene.light.baked;
  ASSERT_EQ(baked.page_side, 128);
  ASSERT_EQ(baked.texels.size(), 128u * 128u);
  EXPECT_EQ(baked.texels[5 * 128 + 9], glm::vec3(9, 5, 7) * kOfCode);
  ASSERT_EQ(baked.triangle_page.size(), scene.triangles.size());
  ASSERT_EQ(baked.vertex_place.size(), scene.positions.size());
  ASSERT_EQ(baked.vertex_light.size(), scene.positions.size());
  size_t floor_count = 0;
  for (size_t t = 0; t < scene.triangles.size(); ++t) {
    const bool is_floor = corner(scene, t, 0).y < 1e-4 && corner(scene, t, 1).y < 1e-4 && corner(scene, t, 2).y < 1e-4;
    EXPECT_EQ(baked.triangle_page[t], is_floor ? 0 : BakedLight::kByVertex) << t;
    floor_count += is_floor;
    for (int k = 0; k < 3; ++k) {
      const uint32_t vertex = scene.triangles[t][k];
      const glm::vec3 p = glm::vec3(corner(scene, t, k)) / static_cast<float>(kUnit);
      if (is_floor) {
        // the quad's corners: x along the page's rows, y of the file down them
        EXPECT_NEAR(baked.vertex_place[vertex].x, p.x / 100.0f, 1e-5f);
        EXPECT_NEAR(baked.vertex_place[vertex].y, -p.z / 100.0f, 1e-5f);
      } else {
        // control points evenly spaced in the codes: a quadratic Bézier curve of them is linear in its parameter
        EXPECT_NEAR(baked.vertex_light[vertex].r, 80.0f * (-p.z / 100.0f) * kOfCode, 1e-4f);
        // along the quarter pipe (100, 0), (200, 0), (200, 100): height is 100 t²
        EXPECT_NEAR(baked.vertex_light[vertex].g, 200.0f * std::sqrt(std::max(0.0f, p.y) / 100.0f) * kOfCode, 2e-3f);
      }
    }
  }
  EXPECT_EQ(floor_count, 2u);
}

TEST_F(BspLight, PagesThatAreNotThereMeanLightByVertex) {
  BspParts parts = litLevel();
  parts.faces[0].lightmap = 1;
  const BspLevel level = read(parts);
  for (const int32_t page : level.scene.light.baked.triangle_page) EXPECT_EQ(page, BakedLight::kByVertex);
  ASSERT_EQ(level.light_notes.size(), 1u);
  EXPECT_EQ(level.light_notes[0],
            "faces that are lit by their vertices, as the engine does it: 1 of lightmap -3, 1 of lightmap 1");
}

TEST_F(BspLight, StaysInStepWithTrianglesThatAreDroppedAndSorted) {
  BspParts parts;
  parts.shaders.push_back({"textures/test/stone"});
  parts.beginModel();
  // pages by height: 0 and 1 in turn, a flat face between them, and two islands whose faces alternate
  parts.addLightmap();
  parts.addLightmap();
  for (int i = 0; i < 6; ++i) {
    const float x = i % 2 == 0 ? 0.0f : 5000.0f, z = 10.0f * static_cast<float>(i);
    parts.addFace(0, 1, {{x, 0, z}, {x, 100, z + 10}, {x + 100, 100, z + 10}, {x + 100, 0, z}});
    parts.faces.back().lightmap = i < 3 ? 0 : 1;
    parts.addFace(0, 1, {{x, 0, 5}, {x + 10, 0, 5}, {x + 20, 0, 5}, {x + 30, 0, 5}});
    parts.faces.back().lightmap = 1;
  }
  const Scene scene = read(parts).scene;
  EXPECT_EQ(scene.dropped_triangle_count, 12u);
  ASSERT_EQ(scene.light.baked.triangle_page.size(), scene.triangles.size());
  for (size_t t = 0; t < scene.triangles.size(); ++t) {
    float low = 1e9f;
    for (int k = 0; k < 3; ++k) low = std::min(low, static_cast<float>(corner(scene, t, k).y) / static_cast<float>(kUnit));
    EXPECT_EQ(scene.light.baked.triangle_page[t], low < 25.0f ? 0 : 1) << "triangle " << t << " at height " << low;
  }
}

TEST_F(BspLight, SkyFacesAreNoGeometryButLieInsideTheBounds) {
  const Scene scene = read(levelWithSky()).scene, without = read(litLevel()).scene;
  EXPECT_EQ(scene.positions.size(), without.positions.size());
  EXPECT_NE(sceneSha256(scene), sceneSha256(without)) << "whether a place is in solid hangs on the sky";
  EXPECT_NE(sceneLightSha256(scene), sceneLightSha256(without));
  const SkyFaces& sky = scene.light.sky_faces;
  ASSERT_EQ(sky.triangles.size(), 2u);
  EXPECT_TRUE(sky.shine.empty());
  for (const glm::uvec3& t : sky.triangles) {
    const glm::vec3 a = sky.positions[t.x];
    EXPECT_LT(glm::cross(sky.positions[t.y] - a, sky.positions[t.z] - a).y, 0.0f) << "it faces down";
    EXPECT_NEAR(a.y + scene.origin_m.y, 1000 * kUnit, 1e-4);
  }
  EXPECT_NEAR(sceneBounds(scene).max.y + scene.origin_m.y, 1000 * kUnit, 1e-4);
  EXPECT_LT(objectBounds(scene, scene.objects[0]).max.y + scene.origin_m.y, 101 * kUnit);
}

TEST_F(BspLight, VariantsKeepTheSkyAndLoseWhatLayOnSurfaces) {
  BspParts parts = levelWithSky();
  parts.entities += "{ \"classname\" \"light\" \"origin\" \"10 20 30\" }";
  const Scene scene = read(parts).scene;
  const Scene variant = jitterScene(scene, {}, 1);
  EXPECT_TRUE(variant.light.baked.empty());
  EXPECT_EQ(variant.light.sky_faces.triangles, scene.light.sky_faces.triangles);
  ASSERT_EQ(variant.light.lamps.size(), 1u);
  EXPECT_EQ(variant.light.lamps[0].position, scene.light.lamps[0].position);
}

TEST_F(BspLight, LampsGiveTheCodesThatTheCompilerGives) {
  BspParts parts = litLevel();
  parts.entities +=
      "{ \"classname\" \"light\" \"origin\" \"100 200 300\" \"light\" \"200\" \"_color\" \"1 .5 0\" }"
      "{ \"classname\" \"light\" \"origin\" \"0 0 100\" \"target\" \"below\" \"radius\" \"48\" }"
      "{ \"classname\" \"info_null\" \"origin\" \"0 0 0\" \"targetname\" \"below\" }"
      "{ \"classname\" \"light\" \"origin\" \"0 0 0\" \"light\" \"80\" \"spawnflags\" \"1\" }"
      "{ \"classname\" \"light\" \"light\" \"80\" }"
      "{ \"classname\" \"lightJunior\" \"origin\" \"0 0 0\" }"
      "{ \"classname\" \"light\" \"origin\" \"0 0 500\" \"light\" \"70\" \"_sun\" \"1\" \"target\" \"below\" }";
  const BspLevel level = read(parts);
  const Scene& scene = level.scene;
  const std::vector<Lamp>& lamps = scene.light.lamps;
  ASSERT_EQ(lamps.size(), 3u);
  expectNear(scene.origin_m + glm::dvec3(lamps[0].position), kUnit * glm::dvec3(100, 300, -200), "the lamp's place", 1e-4);
  // 7500 * 200 / d² codes at d units: 150 at 100 units, which a lightmap holds as irradiance over pi
  const double distance_m = 100 * kUnit;
  const glm::vec3 light = lamps[0].intensity / static_cast<float>(distance_m * distance_m) / kPi;
  EXPECT_NEAR(light.r, 150.0f * kOfCode, 1e-4f);
  EXPECT_NEAR(light.g, 75.0f * kOfCode, 1e-4f);
  EXPECT_EQ(light.b, 0.0f);
  EXPECT_LE(lamps[0].cos_outer, -1.0f) << "shines all round";
  // the spot: 48 + 16 units around its target, 100 units away
  EXPECT_NEAR(lamps[1].direction.y, -1.0f, 1e-6f);
  EXPECT_NEAR(lamps[1].cos_outer, 100.0f / std::hypot(100.0f, 64.0f), 1e-5f);
  EXPECT_NEAR(lamps[1].cos_inner, 100.0f / std::hypot(100.0f, 32.0f), 1e-5f);
  // a linear one gives 75 - d codes: the same at d = 37.5
  const double half_way_m = 37.5 * kUnit;
  EXPECT_NEAR(lamps[2].intensity.r / (half_way_m * half_way_m) / kPi, 37.5 * kOfCode, 1e-4);
  ASSERT_EQ(scene.light.suns.size(), 1u);
  EXPECT_NEAR(scene.light.suns[0].to_sun.y, 1.0f, 1e-6f);
  EXPECT_NEAR(scene.light.suns[0].irradiance.g / kPi, 70.0f * kOfCode, 1e-4f);
  ASSERT_EQ(level.light_notes.size(), 3u);
  EXPECT_EQ(level.light_notes[0], "faces that are lit by their vertices, as the engine does it: 1 of lightmap -3");
  EXPECT_NE(level.light_notes[1].find("1 lamps without an origin"), std::string::npos);
  EXPECT_NE(level.light_notes[2].find("1 lamps that fade linearly"), std::string::npos);
}

TEST_F(BspLight, TheFirstEntityOfATargetsNameCounts) {
  const auto direction = [](const std::string& targets) {
    const std::string lamp = R"({"classname" "light" "origin" "0 0 0" "target" "t"})";
    const EntityLights lights = entityLights(readEntities("level.bsp", lamp + targets));
    return lights.lamps.at(0).cos_outer > -1.0f ? lights.lamps[0].direction : glm::vec3(0.0f);
  };
  const std::string up = R"({"targetname" "t" "origin" "0 0 8"})", down = R"({"targetname" "t" "origin" "0 0 -8"})";
  EXPECT_EQ(direction(up + down), glm::vec3(0, 1, 0));
  EXPECT_EQ(direction(down + up), glm::vec3(0, -1, 0));
  EXPECT_EQ(direction(R"({"targetname" "t"})" + up), glm::vec3(0.0f)) << "the first has no place";
  EXPECT_EQ(direction(R"({"targetname" ""})"), glm::vec3(0.0f));
}

TEST_F(BspLight, SunsShineFromWhereTheirScriptSays) {
  // 90 degrees from the file's x is its y, which is our -z; 30 degrees above the horizon
  const Sun sun = sunOf({{2.0, 1.0, 0.5}, 100.0, 90.0, 30.0, 2.0});
  expectNear(glm::dvec3(sun.to_sun), {0.0, 0.5, -std::sqrt(0.75)}, "where the sun stands");
  EXPECT_NEAR(sun.irradiance.r / kPi, 100.0f * kOfCode, 1e-4f) << "100 codes on what faces it";
  EXPECT_NEAR(sun.irradiance.b / kPi, 25.0f * kOfCode, 1e-4f);
  EXPECT_NEAR(sun.angular_radius, 2.0f * kPi / 180.0f, 1e-6f);
}

class BspLightOfScripts : public BspLight {
 protected:
  // green.tga is (64, 128, 0) in codes
  Scene readWith(BspParts parts, const std::string& script, const std::string& extra_image = "") const {
    const std::string header = std::string("\0\0\2\0\0\0\0\0\0\0\0\0\1\0\1\0\x18\0", 18);
    std::vector<std::pair<std::string, std::string>> files = {{"maps/lit.bsp", parts.bytes()},
                                                              {"textures/test/green.tga", header + std::string("\0\x80\x40", 3)},
                                                              {"scripts/test.shader", script}};
    if (!extra_image.empty()) files.push_back({extra_image, header + std::string("\xff\xff\xff", 3)});
    writeZip(folder_ / "pak.pk3", files);
    return readBspFromArchives(folder_.string(), "lit").scene;
  }
};

TEST_F(BspLightOfScripts, SurfaceLightIsThreeQuartersOfItsCodesInItsOwnHue) {
  const Scene scene =
      readWith(litLevel(), "textures/test/stone\n{\n q3map_surfacelight 1000\n q3map_lightImage textures/test/green.tga\n}\n");
  ASSERT_EQ(scene.materials.size(), 1u);
  EXPECT_NEAR(scene.materials[0].emissive.r, 375.0f * kOfCode, 1e-3f) << "64 over 128 of the green";
  EXPECT_NEAR(scene.materials[0].emissive.g, 750.0f * kOfCode, 1e-3f);
  EXPECT_EQ(scene.materials[0].emissive.b, 0.0f);
  const Scene blue = readWith(litLevel(), "textures/test/stone\n{\n q3map_lightRGB 0 0 .5\n q3map_surfacelight 100\n}\n");
  EXPECT_EQ(blue.materials[0].emissive.g, 0.0f);
  EXPECT_NEAR(blue.materials[0].emissive.b, 75.0f * kOfCode, 1e-3f);
}

// Pages in files: as a shader of compilers with -external names them, or by their number. All stand at the side of the largest.
TEST_F(BspLightOfScripts, PagesOfLightLieInFiles) {
  BspParts parts = litLevel();
  const std::string script =
      "textures/test/stone\n{\n {\n map maps/lit/lm_0003.tga\n tcGen lightmap\n }\n {\n map textures/test/green.tga\n }\n}\n";
  const std::string rows = pixels(256 * 128, std::string("\x1e\x14\x0a", 3)) + pixels(256 * 128, std::string("\x3c\x28\x14", 3));
  std::string page = targa(2, 0, 0, 24, rows);
  page[13] = page[15] = 1;  // 256 x 256, from the bottom
  const auto levelOf = [&](int32_t lightmap, const std::string& text, const std::string& file) {
    parts.faces[0].lightmap = lightmap;
    writeZip(folder_ / "pak.pk3", {{"maps/lit.bsp", parts.bytes()},
                                   {"scripts/test.shader", text},
                                   {file, page},
                                   {"textures/test/green.tga", targa(2, 1, 1, 24, std::string("\0\x80\x40", 3))}});
    return readBspFromArchives(folder_.string(), "lit");
  };
  for (const auto& [lightmap, text] : {std::pair<int32_t, std::string>(-3, script), {-2, script}, {3, ""}}) {
    const BspLevel level = levelOf(lightmap, text, "maps/lit/lm_0003.tga");
    const BakedLight& baked = level.scene.light.baked;
    ASSERT_EQ(baked.page_side, 256) << lightmap;
    ASSERT_EQ(baked.texels.size(), 2u * 256 * 256);
    EXPECT_EQ(baked.texels[(5 * 256 + 9) * 2], glm::vec3(9, 5, 7) * kOfCode)
        << "of the level's own page every texel twice, in twos";
    EXPECT_EQ(baked.texels[256 * 256], glm::vec3(20, 40, 60) * kOfCode) << "the upper row";
    EXPECT_EQ(baked.texels.back(), glm::vec3(10, 20, 30) * kOfCode);
    // the pipe has the floor's shader, and so its page, where the script names one
    const bool is_named = !text.empty();
    EXPECT_EQ(std::count(baked.triangle_page.begin(), baked.triangle_page.end(), 1),
              is_named ? static_cast<int64_t>(baked.triangle_page.size()) : 2);
    const float red = baseColourAt(level.scene, 0, 0.3f, 0.3f).r;
    EXPECT_EQ(red, is_named ? linearFromSrgb(0x40) : 0.5f) << "not the page";
  }
  const BspLevel missing = levelOf(-3, script, "maps/lit/lm_0004.tga");
  EXPECT_EQ(missing.light_notes.at(0),
            "faces that are lit by their vertices, as the engine does it: 2 of lightmap -3, whose pages are not read: "
            "maps/lit/lm_0003");
  for (const int32_t at : missing.scene.light.baked.triangle_page) EXPECT_EQ(at, BakedLight::kByVertex);
}

TEST_F(BspLightOfScripts, LavaShinesThoughItIsNoGeometry) {
  BspParts parts = levelWithSky();
  parts.shaders.push_back({"textures/test/lava", 0, kLavaFlag});
  parts.addFace(2, 1, {{0, 0, -5}, {0, 100, -5}, {100, 100, -5}, {100, 0, -5}});
  const Scene scene = readWith(parts, "textures/test/lava\n{\n q3map_surfacelight 10\n q3map_lightRGB 1 0 0\n cull none\n}\n");
  const SkyFaces& faces = scene.light.sky_faces;
  ASSERT_EQ(faces.triangles.size(), 6u) << "two of sky, two of lava, and their backs";
  ASSERT_EQ(faces.shine.size(), 4u);
  const Sky grey{glm::vec3(0.5f), glm::vec3(0.5f), glm::vec3(0.5f)};
  double upward = 0.0;
  for (uint32_t t = 0; t < 6; ++t) {
    const glm::uvec3& corners = faces.triangles[t];
    const glm::vec3 a = faces.positions[corners.x];
    const float up = glm::cross(faces.positions[corners.y] - a, faces.positions[corners.z] - a).y;
    EXPECT_EQ(faces.shines(t), t >= 2);
    EXPECT_NEAR(faces.radiance(t, {0, 1, 0}, grey).r, t < 2 ? 0.5f : 7.5f * kOfCode, 1e-5f);
    if (t >= 2) upward += up;
  }
  EXPECT_NEAR(upward, 0.0, 1e-6) << "as much upward as downward";
  EXPECT_EQ(scene.positions.size(), readWith(litLevel(), "").positions.size());
}

TEST_F(BspLightOfScripts, SkyShinesWithWhatTheCompilerTookItForThenWithItsLooks) {
  const SceneLight lit = readWith(levelWithSky(),
                                  "textures/skies/blue\n{\n q3map_surfacelight 100\n q3map_skylight 50 3\n"
                                  " q3map_lightrgb 0 0 1\n q3map_sun 1 1 1 80 0 90\n}\n")
                             .light;
  EXPECT_NEAR(lit.sky.zenith.b, (75.0f + 50.0f * 2.0f / kPi) * kOfCode, 1e-4f);
  EXPECT_EQ(lit.sky.zenith, lit.sky.ground);
  EXPECT_EQ(lit.sky.zenith.r, 0.0f);
  ASSERT_EQ(lit.suns.size(), 1u);
  EXPECT_NEAR(lit.suns[0].to_sun.y, 1.0f, 1e-6f);
  const Sky box = readWith(levelWithSky(), "textures/skies/blue\n{\n skyparms env/box 512 -\n}\n", "env/box_up.tga").light.sky;
  EXPECT_EQ(box.zenith, glm::vec3(1.0f));
  // sRGB code 128 is 0.2159 in linear light
  const Sky cloud = readWith(levelWithSky(), "textures/skies/blue\n{\n {\n map textures/test/green.tga\n }\n}\n").light.sky;
  EXPECT_NEAR(cloud.horizon.g, 0.2159f, 1e-4f);
  EXPECT_EQ(readWith(levelWithSky(), "").light.sky.zenith, glm::vec3(0.0f)) << "nothing is known of it";
}

}  // namespace
}  // namespace nlg
