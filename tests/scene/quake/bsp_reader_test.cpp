#include "scene/quake/bsp_reader.h"

#include <gtest/gtest.h>

#include "hand_built_bsp.h"
#include "scene/archive/pk3_archive.h"
#include "scene/model/surface_look.h"
#include "scene/quake/bsp_file.h"
#include "scene/quake/bsp_looks.h"
#include "scene/scene_source.h"
#include "scene/solid/transmissive.h"
#include "tests/datagen/hand_built_scenes.h"
#include "tests/input_error.h"
#include "tests/scene/image/hand_built_images.h"
#include "tests/scene/scene_triangles.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

class BspReader : public testing::Test {
 protected:
  BspLevel read(const BspParts& parts) const { return readBsp(folder_.write("level.bsp", parts.bytes())); }

  TemporaryFolder folder_;
};

TEST_F(BspReader, TurnsAxesUnitsAndWinding) {
  const BspLevel level = read(smallLevel());
  const Scene& scene = level.scene;
  EXPECT_EQ(scene.id, "level");
  ASSERT_GE(scene.triangles.size(), 4u);
  double floor_area = 0.0;
  for (size_t i = 0; i < 2; ++i) {
    const glm::dvec3 normal = normalOf(scene, i);
    EXPECT_GT(normal.y, 0.0) << "the floor looks up";
    EXPECT_NEAR(normal.x, 0.0, 1e-6);
    floor_area += 0.5 * glm::length(normal);
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 p = corner(scene, i, k);
      EXPECT_NEAR(p.y, 0.0, 1e-6);
      EXPECT_TRUE(p.x > -1e-6 && p.x < 100 * kUnit + 1e-6) << p.x;
      EXPECT_TRUE(p.z < 1e-6 && p.z > -100 * kUnit - 1e-6) << "y of the file is -z: " << p.z;
    }
  }
  EXPECT_NEAR(floor_area, 100 * kUnit * 100 * kUnit, 1e-4);
  for (size_t i = 2; i < scene.triangles.size(); ++i) {
    const glm::dvec3 normal = normalOf(scene, i);
    EXPECT_LT(normal.x, 0.0) << "the quarter pipe's inside looks left and up";
    EXPECT_GT(normal.y, 0.0);
  }
  EXPECT_EQ(scene.origin_m, glm::round(scene.origin_m));
}

TEST_F(BspReader, FacesThatAreNoGeometryAreDroppedAndCounted) {
  BspParts parts = smallLevel();
  const std::vector<glm::vec3> quad = {{0, 0, 9}, {0, 9, 9}, {9, 9, 9}, {9, 0, 9}};
  // sky, nodraw, fog, water, lava, slime, playerclip, translucent
  const std::vector<std::pair<uint32_t, uint32_t>> flags = {{0x4, 0}, {0x80, 0}, {0, 0x40},    {0, 0x20},
                                                            {0, 0x8}, {0, 0x10}, {0, 0x10000}, {0, 0x20000000}};
  for (const auto& [surface, contents] : flags) {
    parts.shaders.push_back({"textures/x" + std::to_string(parts.shaders.size()), surface, contents});
    parts.addFace(static_cast<uint32_t>(parts.shaders.size()) - 1, 1, quad);
  }
  parts.addFace(0, 4, quad);
  const BspLevel level = read(parts);
  const std::map<std::string, uint32_t> expected = {{"sky", 1},  {"nodraw", 1},      {"fog", 1},  {"liquid", 3},
                                                    {"clip", 1}, {"translucent", 1}, {"flare", 1}};
  EXPECT_EQ(level.dropped_faces, expected);
  EXPECT_EQ(level.scene.triangles.size(), read(smallLevel()).scene.triangles.size());
  EXPECT_EQ(level.scene.materials.size(), 1u) << "materials of dropped faces are none";
}

TEST_F(BspReader, ShaderNamesEndAtTheirNul) {
  BspParts parts = smallLevel();
  parts.shaders[0].name = std::string("textures/test/stone\0textures/common/caulk", 41);
  EXPECT_EQ(parseBsp("x", parts.bytes()).shaders[0].name, "textures/test/stone");
}

TEST_F(BspReader, FlatTrianglesAreDroppedAndCounted) {
  BspParts parts = smallLevel();
  const size_t count = read(parts).scene.triangles.size();
  parts.addFace(0, 1, {{0, 0, 5}, {10, 0, 5}, {20, 0, 5}, {30, 0, 5}});
  const BspLevel level = read(parts);
  EXPECT_EQ(level.scene.triangles.size(), count);
  EXPECT_EQ(level.scene.dropped_triangle_count, 2u);
}

TEST_F(BspReader, PlayersBeginWhereTheirEntitiesStand) {
  BspParts parts = smallLevel();
  parts.entities +=
      "{ \"classname\" \"info_player_deathmatch\" \"origin\" \"100 200 -30\" \"angle\" \"90\" }"
      "{ \"classname\" \"info_player_deathmatch\" }"
      "{ \"classname\" \"info_player_deathmatch\" \"origin\" \"8 9 10\" }";
  const Scene scene = read(parts).scene;
  // the second has no origin
  ASSERT_EQ(scene.viewpoints.size(), 2u);
  const Viewpoint& first = scene.viewpoints[0];
  EXPECT_EQ(first.name, "info_player_deathmatch 0");
  EXPECT_EQ(scene.viewpoints[1].name, "info_player_deathmatch 1");
  // eyes are 26 units above the origin; 90 degrees turn x into y, which is -z here
  expectNear(scene.origin_m + glm::dvec3(first.position), kUnit * glm::dvec3(100, -4, -200), "the player's eyes", 1e-5);
  EXPECT_NEAR(first.forward.z, -1.0f, 1e-6f);
  EXPECT_NEAR(scene.viewpoints[1].forward.x, 1.0f, 1e-6f);
  EXPECT_EQ(first.fov_y, 0.0f);
}

TEST_F(BspReader, SubmodelsAreMovableObjectsWhereTheirEntityStands) {
  BspParts parts = smallLevel();
  parts.entities += "{ \"classname\" \"func_door\" \"model\" \"*1\" \"origin\" \"1000 200 -30.5\" }{ \"model\" \"*2\" }";
  parts.beginModel();
  parts.addFace(0, 1, {{0, 0, 0}, {0, 10, 0}, {10, 10, 0}, {10, 0, 0}});
  parts.beginModel();  // without a face: no object
  const Scene scene = read(parts).scene;
  const SceneObject& door = scene.objects.back();
  EXPECT_EQ(door.name, "func_door *1");
  EXPECT_TRUE(door.movable);
  ASSERT_EQ(door.triangle_count, 2u);
  const Bounds bounds = objectBounds(scene, door);
  EXPECT_NEAR(bounds.min.x + scene.origin_m.x, 1000 * kUnit, 1e-5);
  EXPECT_NEAR(bounds.max.y + scene.origin_m.y, -30.5 * kUnit, 1e-5);
  EXPECT_NEAR(bounds.max.z + scene.origin_m.z, -200 * kUnit, 1e-5);
  uint32_t next = 0;
  for (const SceneObject& object : scene.objects) {
    EXPECT_EQ(object.first_triangle, next);
    next += object.triangle_count;
  }
  EXPECT_EQ(next, scene.triangles.size());
}

// Six quads around a box, corners clockwise from outside; inside out for a room. Sides are left out by their number.
void addBox(BspParts& parts, const glm::vec3& low, const glm::vec3& high, bool is_room, int left_out = -1) {
  const auto sides = boxSides(low, high);
  for (int side = 0; side < 6; ++side) {
    const auto& [a, b, c, d] = sides[side];
    if (side != left_out) parts.addFace(0, 1, is_room ? std::vector{a, b, c, d} : std::vector{d, c, b, a});
  }
}

TEST_F(BspReader, WhatStandsFreeMovesAndTheShellDoesNot) {
  BspParts parts;
  parts.shaders.push_back({"textures/test/stone"});
  parts.beginModel();
  addBox(parts, {0, 0, 0}, {1000, 1000, 300}, true);                      // the room
  addBox(parts, {100, 100, 1}, {150, 150, 51}, false);                    // a crate
  addBox(parts, {300, 300, 1}, {350, 350, 51}, false, 4);                 // one without its bottom
  addBox(parts, {500, 500, 1}, {550, 550, 51}, true);                     // one whose faces look inward
  parts.addFace(0, 1, {{0, 1, 9}, {0, 90, 9}, {90, 90, 9}, {90, 1, 9}});  // a sheet
  addBox(parts, {2000, 0, 0}, {2600, 600, 600}, false);                   // a building, 15 m
  const Scene scene = read(parts).scene;
  ASSERT_EQ(scene.objects.size(), 6u);
  const bool expected[] = {false, true, true, false, false, false};
  for (size_t i = 0; i < 6; ++i) EXPECT_EQ(scene.objects[i].movable, expected[i]) << scene.objects[i].name;
}

BspParts levelWithDoor() {
  BspParts parts = smallLevel();
  parts.entities += "{ \"model\" \"*1\" \"origin\" \"1 2 3\" }";
  parts.beginModel();
  parts.addFace(0, 3, {{0, 0, 0}, {0, 10, 0}, {10, 10, 0}, {10, 0, 0}});
  return parts;
}

class BspInArchives : public BspReader {
 protected:
  BspInArchives() {
    const std::string red = std::string("\0\0\2\0\0\0\0\0\0\0\0\0\1\0\1\0\x18\0", 18) + std::string("\0\0\xff", 3);
    writeZip(folder_ / "pak1.pk3", {{"maps/Small.bsp", levelWithDoor().bytes()},
                                    {"textures/test/stone.tga", red},
                                    {"scripts/test.shader", "textures/test/stone\n{\n cull disable\n}\n"}});
  }
};

TEST_F(BspInArchives, LooksComeFromScriptsAndTextures) {
  const BspLevel level = readBspFromArchives(folder_.string(), "SMALL");
  EXPECT_EQ(level.scene.id, "small");
  ASSERT_EQ(level.scene.materials.size(), 1u);
  EXPECT_EQ(baseColourAt(level.scene, 0, 0.3f, 0.3f), glm::vec3(1, 0, 0));
  EXPECT_TRUE(level.scene.materials[0].double_sided);
  EXPECT_EQ(level.materials_without_texture, 0u);
  writeZip(folder_ / "pak2.pk3", {{"scripts/test.shader", "textures/test/stone\n{\n surfaceparm trans\n}\n"}});
  const BspLevel dropped = readBspFromArchives(folder_.string(), "small");
  EXPECT_TRUE(dropped.scene.triangles.empty());
  EXPECT_EQ(dropped.dropped_faces, (std::map<std::string, uint32_t>{{"translucent", 3}}));
}

// Bilinear between the middles of four texels.
TEST_F(BspInArchives, TexturesLieWhereTheFileSays) {
  BspParts parts = smallLevel();
  // the floor's corners: places (0, 0), (0, 1), (1, 1), (1, 0)
  for (const glm::vec2& place : {glm::vec2(0, 0), {0, 1}, {1, 1}, {1, 0}}) parts.texture_places.push_back(place);
  const std::string columns = png(2, 1, std::string("\xff\0\0\xff\0\xff\0\xff", 8));
  writeZip(folder_ / "pak2.pk3", {{"maps/placed.bsp", parts.bytes()}, {"textures/test/stone.png", columns}});
  writeZip(folder_ / "pak3.pk3", {{"textures/test/stone.tga", "damaged: the next one is taken"}});
  const BspLevel level = readBspFromArchives(folder_.string(), "placed");
  EXPECT_EQ(level.materials_without_texture, 0u);
  const Scene& scene = level.scene;
  ASSERT_EQ(scene.base_places.size(), scene.positions.size());
  for (size_t i = 0; i < 4; ++i) {
    // 100 units are 2.54 m; the file's x is the scene's
    const glm::dvec3 world = scene.origin_m + glm::dvec3(scene.positions[i]);
    EXPECT_NEAR(scene.base_places[i].x, world.x / 2.54, 1e-5);
    EXPECT_NEAR(scene.base_places[i].y, -world.z / 2.54, 1e-5);
  }
  const std::vector<glm::dvec4> means =
      meansOfMaterials(scene, {true}, [&](uint32_t t, float u, float v) { return glm::dvec3(baseColourAt(scene, t, u, v)); });
  EXPECT_EQ(scene.images.size(), 1u);
  EXPECT_NEAR(means[0].x + means[0].y, 1.0, 1e-6) << "red and green";
}

TEST_F(BspInArchives, WhatAScriptCutsOutIsTransmissive) {
  BspParts parts = smallLevel();
  for (const glm::vec2& place : {glm::vec2(0, 0), {0, 1}, {1, 1}, {1, 0}}) parts.texture_places.push_back(place);
  const std::string halves = png(4, 1, pixels(3, std::string("\xff\xff\xff\x7f", 4)) + "\xff\xff\xff\x80");
  const struct {
    const char* function;
    Transmissive transmissive;
  } cases[] = {{"GE128", Transmissive::thin}, {"GT0", Transmissive::none}, {"LT128", Transmissive::none}};
  for (const auto& one : cases) {
    const std::string script =
        "textures/test/stone\n{\n qer_editorimage textures/other\n { map $lightmap }\n {\n map textures/grate.tga\n alphaFunc " +
        std::string(one.function) + "\n }\n}\n";
    writeZip(folder_ / "pak2.pk3",
             {{"maps/grate.bsp", parts.bytes()}, {"textures/grate.png", halves}, {"scripts/test.shader", script}});
    const BspLevel level = readBspFromArchives(folder_.string(), "grate");
    EXPECT_EQ(static_cast<int>(level.scene.materials[0].transmissive), static_cast<int>(one.transmissive)) << one.function;
    EXPECT_EQ(level.notes.size(), one.transmissive == Transmissive::none ? 0u : 1u);
    EXPECT_EQ(level.scene.images.size(), 1u);
  }
  EXPECT_EQ(static_cast<int>(readBspFromArchives(folder_.string(), "grate", 0.0).scene.materials[0].transmissive),
            static_cast<int>(Transmissive::none))
      << "the last one cuts nothing out";
}

TEST_F(BspInArchives, ScenesAreRequestedByPathAndMap) {
  for (const std::string& request : {folder_.string() + ":small", folder_ / "pak1.pk3:Small", folder_.string() + "/:small"}) {
    const SceneSource source = loadScene(request);
    EXPECT_EQ(source.family, "level");
    EXPECT_EQ(source.id, "small") << request;
    EXPECT_EQ(source.sha256, sceneSha256(source.scene));
    EXPECT_FALSE(source.scene.triangles.empty());
  }
  const std::string file = folder_.write("with:colon.bsp", smallLevel().bytes());
  EXPECT_EQ(loadScene(file).id, "with:colon");
  EXPECT_EQ(loadScene(file).sha256, sceneSha256(loadScene(file).scene));
  // a procedural scene has that name
  EXPECT_EQ(loadScene(folder_.write("house_3.BSP", smallLevel().bytes())).id, "house_3.bsp");
  EXPECT_EQ(loadScene(folder_.write("room_3.bsp", smallLevel().bytes())).id, "room_3");
}

TEST_F(BspInArchives, RefusesMapsThatAreNotThere) {
  for (const std::string& map : {std::string("large"), std::string(), std::string("../small"), std::string("x/small")}) {
    expectInputError("one of small", [&] { loadScene(folder_.string() + ":" + map); });
  }
  EXPECT_THROW(loadScene(folder_ / "missing.pk3:small"), InputError);
}

// Every twelfth of the levels of docs/guide/levels.md, where their packages are installed, or unpacked below NLG_ARCHIVE_ROOT.
TEST(InstalledLevels, Load) {
  const char* root = std::getenv("NLG_ARCHIVE_ROOT");
  int found_count = 0;
  for (const char* folder : {"openarena/baseoa", "nexuiz/data"}) {
    const std::string path = std::string(root != nullptr ? root : "") + "/usr/share/games/" + folder;
    if (!std::filesystem::is_directory(path)) continue;
    for (const std::string& name : Pk3Archives(path).names("maps/", ".bsp")) {
      const std::string map = name.substr(5, name.size() - 9);
      if (map.find('/') != std::string::npos || found_count++ % 12 != 0) continue;
      const BspLevel level = readBspFromArchives(path, map);
      EXPECT_GT(level.scene.triangles.size(), 400u) << map;
      // all that is drawn of a level is more than what is dropped for having no area
      EXPECT_LT(level.scene.dropped_triangle_count, level.scene.triangles.size()) << map;
    }
  }
  if (found_count == 0) GTEST_SKIP() << "no levels installed";
}

}  // namespace
}  // namespace nlg
