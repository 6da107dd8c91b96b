#include "scene/obj/obj_reader.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "scene/model/surface_look.h"
#include "scene/scene_source.h"
#include "tests/input_error.h"
#include "tests/scene/image/hand_built_images.h"
#include "tests/scene/scene_triangles.h"
#include "tests/temporary_folder.h"
#include "tool/error.h"

namespace nlg {
namespace {

namespace fs = std::filesystem;

// A unit square in the plane z = 0, front towards +z, and a unit triangle above it.
const char* const kSquare =
    "# a comment\nmtllib looks.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 2\nv 1 0 2\nv 0 1 2\nvt 0 0\nvn 0 0 1\n"
    "o square\nusemtl lamp\nf 1/1/1 2/1/1 3/1/1 4/1/1\no roof\nusemtl brick\ns off\nf -3//1 -2//1 -1//1\nl 1 2\n";
const char* const kLooks =
    "newmtl lamp\nKd 0.25 0.5 0.75\nKe 8 4 0\nmap_Ka bricks.png\nd 1\nNs 10\nnewmtl brick\nKd 0.5 0.25 0.125\n";

class ObjReader : public testing::Test {
 protected:
  ObjReader() {
    fs::create_directory(folder_ / "level");
    write("looks.mtl", kLooks);
  }

  std::string write(const std::string& name, const std::string& text) const { return folder_.write("level/" + name, text); }
  ObjLevel read(const std::string& text, double unit_m = 1.0) const { return readObj(write("test.obj", text), unit_m); }
  std::string errorOf(const std::string& text) const {
    return inputErrorOf([&] { read(text); });
  }

  TemporaryFolder folder_;
};

TEST_F(ObjReader, ReadsObjectsFacesAndMaterials) {
  const ObjLevel level = read(kSquare);
  const Scene& scene = level.scene;
  EXPECT_EQ(scene.id, "test");
  EXPECT_TRUE(level.notes.empty()) << level.notes[0];
  ASSERT_EQ(scene.triangles.size(), 3u);
  EXPECT_EQ(scene.positions.size(), 7u);
  ASSERT_EQ(scene.objects.size(), 2u);
  EXPECT_EQ(scene.objects[0].name, "square");
  EXPECT_EQ(scene.objects[0].triangle_count, 2u);
  EXPECT_EQ(scene.objects[1].name, "roof");
  EXPECT_EQ(scene.objects[1].first_triangle, 2u);
  for (size_t i = 0; i < 3; ++i)
    EXPECT_EQ(normalOf(scene, i), glm::dvec3(0, 0, 1)) << "each is half a unit square, from in front";
  EXPECT_EQ(corner(scene, 2, 0), glm::dvec3(0, 0, 2));
  const Material& lamp = scene.materials[scene.triangle_material[0]];
  EXPECT_EQ(lamp.base_color, glm::vec3(0.25f, 0.5f, 0.75f));
  EXPECT_EQ(lamp.emissive, glm::vec3(8, 4, 0));
  EXPECT_FALSE(lamp.double_sided);
  EXPECT_EQ(scene.materials[scene.triangle_material[2]].base_color, glm::vec3(0.5f, 0.25f, 0.125f));
  EXPECT_EQ(scene.materials[scene.triangle_material[2]].emissive, glm::vec3(0.0f));
}

TEST_F(ObjReader, ScalesByTheUnit) {
  const Scene scene = read(kSquare, 0.5).scene;
  EXPECT_EQ(corner(scene, 2, 0), glm::dvec3(0, 0, 1));
  EXPECT_EQ(normalOf(scene, 0), glm::dvec3(0, 0, 0.25));
}

// 100 km away a float's step is 8 mm.
TEST_F(ObjReader, LosesNoPrecisionFarFromTheOrigin) {
  const Scene scene = read("v 100000 0 0\nv 100000.001 0 0\nv 100000 0.001 0\nf 1 2 3\nv 100001 1 1\nf 1 2 4\n").scene;
  ASSERT_EQ(scene.triangles.size(), 2u);
  EXPECT_NEAR(glm::length(normalOf(scene, 0)), 1e-6, 1e-9);
}

TEST_F(ObjReader, CutsPolygonsThatAreNotConvex) {
  // an L of six corners: three unit squares
  const Scene scene = read("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6\n").scene;
  double area = 0.0;
  for (size_t i = 0; i < scene.triangles.size(); ++i) {
    EXPECT_GT(normalOf(scene, i).z, 0.0) << "triangle " << i << " shows its front";
    area += 0.5 * normalOf(scene, i).z;
  }
  EXPECT_NEAR(area, 3.0, 1e-9);
}

TEST_F(ObjReader, ReadsLinesOfOtherSystems) {
  std::string text = kSquare;
  for (size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2) text.insert(at, "\r");
  EXPECT_EQ(read(text).scene.triangles.size(), 3u);
  EXPECT_EQ(read(text.substr(0, text.size() - 2)).scene.triangles.size(), 3u) << "the last line without an end";
}

TEST_F(ObjReader, CutsColoursAboveOneAndSaysSo) {
  write("looks.mtl", "newmtl lamp\nKd 2 0.5 0\nnewmtl brick\nKd 1 1 1\n");
  const ObjLevel level = read(kSquare);
  EXPECT_EQ(level.scene.materials[level.scene.triangle_material[0]].base_color, glm::vec3(1.0f, 0.5f, 0.0f));
  ASSERT_EQ(level.notes.size(), 1u);
  EXPECT_EQ(level.notes[0], "1 materials with a Kd above 1: cut to 1");
}

// --- images and opacity

// A square, its places on the image those of its corners, lower left first.
const char* const kPlacedSquare =
    "mtllib looks.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl wall\nf 1/1 2/2 3/3 4/4\n";
// Red beside green; the second is half there.
const std::string kHalves("\xff\0\0\xff\0\xff\0\x80", 8);

TEST_F(ObjReader, PutsImagesWhereFacesSay) {
  write("two halves.png", png(2, 1, kHalves));
  write("looks.mtl", "newmtl wall\nKd 1 0.5 1\nmap_Kd -s 1 2 1 -o 0 0.25 0 two halves.png \n");
  const ObjLevel level = read(kPlacedSquare);
  EXPECT_TRUE(level.notes.empty()) << level.notes[0];
  for (uint32_t triangle = 0; triangle < 2; ++triangle) {
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 at = corner(level.scene, triangle, k);
      const glm::vec2 place = level.scene.base_places[level.scene.triangles[triangle][k]];
      EXPECT_EQ(place, glm::vec2(at.x, 1.0 - (2.0 * at.y + 0.25))) << "the file's v points up";
    }
  }
  EXPECT_EQ(level.scene.materials.at(0).transmissive, Transmissive::none) << "colours' own opacity is nothing";
  EXPECT_LT(glm::length(baseColourAt(level.scene, 0, 0.25f, 0.0f) - glm::vec3(1, 0, 0)), 1e-3f);
  EXPECT_LT(glm::length(baseColourAt(level.scene, 0, 0.75f, 0.0f) - glm::vec3(0, 0.5, 0)), 1e-3f);
}

TEST_F(ObjReader, OpacityMakesTransmissiveSurfaces) {
  write("colours.png", png(2, 1, kHalves));
  write("mask.png", png(2, 1, std::string("\0\0\0\xff\xff\xff\xff\xff", 8)));
  const struct {
    const char* looks;
    double stops;
  } cases[] = {{"newmtl wall\nKd 1 1 1\nd 0.25\n", 0.25},
               {"newmtl wall\nKd 1 1 1\nTr 0.25\n", 0.75},
               {"newmtl wall\nKd 1 1 1\nmap_Kd colours.png\nmap_d colours.png\n", 0.75},
               {"newmtl wall\nKd 1 1 1\nmap_Kd colours.png\nmap_d mask.png\n", 0.5},
               {"newmtl wall\nKd 1 1 1\nmap_d mask.png\n", 0.5},
               {"newmtl wall\nKd 1 1 1\nd 1\nTr 0\n", 1.0},
               {"newmtl wall\nKd 1 1 1\nd -halo 0.25\n", 0.25}};
  for (const auto& one : cases) {
    SCOPED_TRACE(one.looks);
    // a material that stops all light goes before: Tr of files without is another thing
    write("looks.mtl", std::string(one.looks) + "newmtl plain\nKd 1 1 1\n");
    const ObjLevel level = read(std::string(kPlacedSquare) + "usemtl plain\nf 1/1 2/2 4/4\n");
    const Material& material = level.scene.materials.at(0);
    EXPECT_EQ(material.transmissive == Transmissive::none, one.stops == 1.0);
    EXPECT_EQ(level.notes.size(), one.stops == 1.0 ? 0u : 1u);
    const double stopped = 0.5 * (stoppedAt(level.scene, 0, 0.25f, 0.0f) + stoppedAt(level.scene, 0, 0.75f, 0.0f));
    EXPECT_NEAR(stopped, one.stops, 0.003);
  }
}

TEST_F(ObjReader, ShinesByItsImage) {
  write("colours.png", png(2, 1, kHalves));
  write("looks.mtl", "newmtl wall\nKd 1 1 1\nKe 8 8 8\nmap_Ke colours.png\n");
  const Scene scene = read(kPlacedSquare).scene;
  EXPECT_TRUE(scene.base_places.empty());
  EXPECT_LT(glm::length(emissionAt(scene, 0, 0.25f, 0.0f) - glm::vec3(8, 0, 0)), 1e-2f);
}

TEST_F(ObjReader, ImagesThatCannotBeReadAreNoted) {
  const struct {
    const char *name, *note;
  } cases[] = {{"missing.png", "is not there"},
               {"C:\\textures\\a.png", "lies outside of the scene's folder and is not opened (tried textures/a.png, a.png)"},
               {"../secret.png", "lies outside of the scene's folder"},
               {"bad.png", "is of no kind that is read"}};
  write("../secret.png", "secret");
  write("bad.png", "no image at all, but long enough");
  for (const auto& one : cases) {
    write("looks.mtl", "newmtl wall\nKd 1 0.5 0\nmap_Kd " + std::string(one.name) + "\n");
    const ObjLevel level = read(kPlacedSquare);
    ASSERT_EQ(level.notes.size(), 1u);
    EXPECT_NE(level.notes[0].find(one.note), std::string::npos) << level.notes[0];
    EXPECT_EQ(level.scene.materials.at(0).base_color, glm::vec3(0.5f, 0.25f, 0.0f));
  }
}

TEST_F(ObjReader, FacesWithoutPlacesLieAtTheCornerOfTheImage) {
  write("colours.png", png(2, 1, kHalves));
  write("looks.mtl", "newmtl wall\nKd 1 1 1\nmap_Kd colours.png\n");
  const ObjLevel level = read("mtllib looks.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nusemtl wall\nf 1 2/9 3/1\n");
  ASSERT_EQ(level.notes.size(), 1u);
  EXPECT_EQ(level.notes[0], "2 vertices without a place on their image (vt): its corner instead");
}

TEST_F(ObjReader, RefusesHostileFilesByNamingTheLine) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";
  std::string many = vertices + "f";
  for (int i = 0; i < 8193; ++i) many += " 1";
  const struct {
    std::string text;
    const char* error;
  } cases[] = {{vertices + "f 1 2 4\n", "line 4: expected a face whose corners are vertices of the file, each three numbers"},
               {many + "\n", "line 4: expected a face of at most 8192 corners, got 8193"},
               {"mtllib ../looks.mtl\n", "no error"},  // not there: noted
               {std::string("v 0 0 0\0\n", 9), "expected text, got a zero byte"}};
  for (const auto& c : cases) {
    const std::string error = errorOf(c.text);
    EXPECT_NE(error.find(c.error), std::string::npos) << c.text.substr(0, 80) << ": " << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
}

TEST_F(ObjReader, LeavesOutFacesWithACornerThatIsNowhere) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";
  for (const char* face : {"1 2 4", "1 2 0", "1 2 -4", "1 2 99999999999999999999", "1 2 4294967295", "1/1 2/1 x/1", "1 2 3 7"}) {
    const ObjLevel level = read(vertices + "f " + face + "\nf 1 2 3\n");
    EXPECT_EQ(level.scene.triangles.size(), 1u) << face;
    EXPECT_NE(level.notes.at(1).find("1 faces whose corners are not all vertices of the file"), std::string::npos) << face;
    EXPECT_NE(level.notes[1].find("left out, the first in line 4"), std::string::npos) << level.notes[1];
  }
  EXPECT_EQ(read("f 1 2 3\n" + vertices).scene.triangles.size(), 1u) << "vertices may stand behind their faces";
  for (const char* odd : {"nan 0 0", "1 x 0", "0 0", "0 0 1e999", "0 0 1,5", "2e9 0 0"}) {
    const std::string vertex = std::string("v ") + odd + "\n";
    const ObjLevel unused = read(vertices + vertex + "f 1 2 3\n");
    EXPECT_EQ(unused.scene.triangles.size(), 1u) << odd;
    EXPECT_EQ(unused.notes.size(), 1u) << odd << ": of a face without a material, and nothing else";
    const ObjLevel used = read(vertices + vertex + "f 1 2 3\nf 1 2 4\nf 4 3 1\n");
    EXPECT_EQ(used.scene.triangles.size(), 1u) << odd;
    EXPECT_EQ(used.notes.at(1),
              "2 faces whose corners are not all vertices of the file, each three numbers within 1e9 m of the origin: left out, "
              "the first in line 6")
        << odd;
    EXPECT_NE(errorOf(vertices + vertex + "f 1 2 4\n").find("line 5: expected a face whose corners are vertices of the file"),
              std::string::npos)
        << odd;
  }
}

// Maya's "Kd 0 0 0" beside an image: most programs show the image.
TEST_F(ObjReader, ABlackFactorBesideAnImageIsSaidAndTheImageShown) {
  write("two halves.png", png(2, 1, kHalves));
  write("looks.mtl", "newmtl wall\nKd 0 0 0\nmap_Kd two halves.png\n");
  const ObjLevel level = read(kPlacedSquare);
  EXPECT_LT(glm::length(baseColourAt(level.scene, 0, 0.25f, 0.0f) - glm::vec3(1, 0, 0)), 1e-3f);
  EXPECT_EQ(level.notes.at(0), "1 materials with a Kd of 0 beside map_Kd: their image shows");
  write("looks.mtl", "newmtl wall\nKd 0 0 0\nmap_Kd missing.png\n");
  const ObjLevel missing = read(kPlacedSquare);
  ASSERT_EQ(missing.notes.size(), 1u);
  EXPECT_NE(missing.notes[0].find("grey in its place"), std::string::npos) << missing.notes[0];
  EXPECT_EQ(missing.scene.materials.at(0).base_color, glm::vec3(0.5f));
  write("looks.mtl", "newmtl wall\nKd 0 0 0\n");
  EXPECT_EQ(read(kPlacedSquare).scene.materials.at(0).base_color, glm::vec3(0.0f)) << "by itself it is black";
}

TEST_F(ObjReader, ReadsContinuedLinesAndNamesOfSeveralWords) {
  write("looks.mtl", "newmtl red  brick\nKd 1 0 0\nnewmtl red paint\nKd 0 0 1\n");
  const Scene scene =
      read(
          "# no continuation: \\\nmtllib looks.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl red brick \nf 1 \\\n2\\\r\n 3\n"
          "usemtl red\tpaint\nf 1 3 4\\")
          .scene;
  ASSERT_EQ(scene.triangles.size(), 2u);
  EXPECT_EQ(scene.materials[scene.triangle_material[0]].base_color, glm::vec3(1, 0, 0));
  EXPECT_EQ(scene.materials[scene.triangle_material[1]].base_color, glm::vec3(0, 0, 1));
  EXPECT_NE(errorOf("v 0 0 0\nf 1 1 \\\n7\n").find("line 3: expected a face whose corners are vertices"), std::string::npos);
}

TEST_F(ObjReader, OpensNoLibraryOutsideTheFolder) {
  std::ofstream(folder_ / "secret.mtl") << kLooks;
  fs::create_symlink(folder_ / "secret.mtl", folder_ / "level/link.mtl");
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl lamp\nf 1 2 3\n";
  for (const char* name : {"../secret.mtl", "link.mtl"}) {
    const ObjLevel level = read(std::string("mtllib ") + name + "\n" + triangle);
    ASSERT_EQ(level.notes.size(), 2u) << name;
    EXPECT_NE(level.notes[0].find(name[0] == 'l' ? "a link out of it" : "lies outside of the scene's folder"), std::string::npos)
        << level.notes[0];
  }
  EXPECT_EQ(read("mtllib " + (folder_ / "secret.mtl") + "\n" + triangle).scene.materials.size(), 1u);
  // but one of that name that lies beside it
  const ObjLevel level = read("mtllib C:\\looks\\looks.mtl\n" + triangle);
  EXPECT_EQ(level.notes, std::vector<std::string>{"mtllib \"C:/looks/looks.mtl\" is read from looks.mtl"});
}

// --- as programs write them

TEST_F(ObjReader, PassesAByteOrderMarkBy) {
  const std::string mark = "\xef\xbb\xbf";
  write("looks.mtl", mark + kLooks);
  for (const std::string& text : {mark + kSquare, mark + "v 9 9 9\n" + kSquare, mark + "\n\n" + kSquare}) {
    const ObjLevel level = read(text);
    EXPECT_TRUE(level.notes.empty()) << level.notes[0];
    EXPECT_EQ(level.scene.materials[level.scene.triangle_material[0]].emissive, glm::vec3(8, 4, 0));
  }
  EXPECT_EQ(corner(read(mark + "v 9 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").scene, 0, 0), glm::dvec3(9, 0, 0));
}

TEST_F(ObjReader, TrMayMeanTheOpposite) {
  const std::string taken = "Tr is taken for what is stopped: by its other meaning no material would stop all light";
  const std::string none = "by d no material would stop any light: all are taken to stop all of it";
  const struct {
    const char *lamp, *brick;
    double stops_lamp, stops_brick;
    std::string note;
  } cases[] = {{"Tr 1", "Tr 1", 1, 1, taken},
               {"Tr 1", "Tr 0.25", 1, 0.25, taken},
               {"Tr 0", "Tr 0.25", 1, 0.75, ""},
               {"Tr 0", "Tr 1", 1, 0, ""},
               {"d 1", "Tr 1", 1, 0, ""},
               {"", "Tr 1", 1, 0, ""},
               {"d 0", "d 0", 1, 1, none},
               {"d 0", "d 0.5", 0, 0.5, ""},
               {"d 1\nTr 1", "Tr 1\nd 1", 1, 1, "2 materials whose d and Tr contradict each other: by d"},
               {"d 0.5\nTr 0.5", "d 1", 0.5, 1, ""}};
  for (const auto& one : cases) {
    SCOPED_TRACE(std::string(one.lamp) + ", " + one.brick);
    write("looks.mtl", std::string("newmtl lamp\nKd 1 1 1\n") + one.lamp + "\nnewmtl brick\nKd 1 1 1\n" + one.brick +
                           "\nnewmtl unused\nTr 0.5\n");
    const ObjLevel level = read(kSquare);
    EXPECT_NEAR(stoppedAt(level.scene, 0, 0.3f, 0.3f), one.stops_lamp, 1e-6);
    EXPECT_NEAR(stoppedAt(level.scene, 2, 0.3f, 0.3f), one.stops_brick, 1e-6);
    const size_t transmissive = (one.stops_lamp < 1.0) + (one.stops_brick < 1.0);
    ASSERT_EQ(level.notes.size(), (one.note.empty() ? 0u : 1u) + (transmissive > 0 ? 1u : 0u));
    if (!one.note.empty()) {
      EXPECT_EQ(level.notes[0], one.note);
    }
  }
}

TEST_F(ObjReader, VerticesHaveColours) {
  write("looks.mtl", "newmtl lamp\nKd 1 0.5 1\n");
  const std::string corners = "v 0 0 0 .6 .05 .2\nv 1 0 0 .6 .05 .2\nv 0 1 0 .6 .05 .2\nv 0 0 1\nv 1 0 1 1\nv 0 1 1\n";
  const Scene scene = read("mtllib looks.mtl\n" + corners + "f 1 2 3\nf 4 5 6\nusemtl lamp\nf 1 2 3\nf 4 5 6\n").scene;
  const glm::vec3 expected[] = {{0.6f, 0.05f, 0.2f}, glm::vec3(0.5f), {0.6f, 0.025f, 0.2f}, {1.0f, 0.5f, 1.0f}};
  for (uint32_t t = 0; t < 4; ++t) EXPECT_LT(glm::length(baseColourAt(scene, t, 0.3f, 0.3f) - expected[t]), 1e-6f) << t;
  const struct {
    const char *first, *last;  // colours of two vertices, and of the third
    glm::vec3 colour;          // of the first
    std::vector<std::string> notes;
  } cases[] = {{"255 51 0", "255 51 0", {1.0f, 0.2f, 0.0f}, {"taken as of 0 to 255"}},
               // one number too large, or below 0, is no sign of codes
               {".5 .2 0", "300 .2 -7", {0.5f, 0.2f, 0.0f}, {"2 numbers outside of 0 to 1 are cut"}},
               {"255 51 0", "300 51 -7", {1.0f, 0.2f, 0.0f}, {"taken as of 0 to 255", "2 numbers outside of 0 to 255 are cut"}},
               {"65535 13107 0", "65535 13107 0", {1.0f, 0.2f, 0.0f}, {"taken as of 0 to 65535"}}};
  for (const auto& one : cases) {
    const std::string first = one.first;
    const ObjLevel level = read("v 0 0 0 " + first + "\nv 1 0 0 " + first + "\nv 0 1 0 " + one.last + "\nf 1 2 3\n");
    EXPECT_LT(glm::length(baseColourAt(level.scene, 0, 0.0f, 0.0f) - one.colour), 1e-6f) << first;
    for (size_t i = 0; i < one.notes.size(); ++i) EXPECT_EQ(level.notes.at(i), "colours of vertices: " + one.notes[i]);
  }
}

TEST_F(ObjReader, ReadsColoursAndImagesInAllTheirForms) {
  write("a b.png", png(1, 1, std::string("\xff\0\0\xff", 4)));
  fs::create_directory(folder_ / "level/textures");
  write("textures/c.png", png(1, 1, std::string("\0\xff\0\xff", 4)));
  const struct {
    const char* looks;
    glm::vec3 colour;
  } cases[] = {{"Kd 0.25", glm::vec3(0.25f)},
               {"Kd xyz 0.4124564 0.2126729 0.0193339", {1, 0, 0}},
               {"Kd 0.5 0.25 0.125 # a comment", {0.5f, 0.25f, 0.125f}},
               {"map_Kd a b.png", {1, 0, 0}},
               {"MAP_KD -blendu on -mm 0 1 -t 0 0 0 -bm 0.5 -s 2 2 2 -o 1 -clamp on a b.png", {1, 0, 0}},
               {"kd 1 1 1\nmap_kd textures\\c.png", {0, 1, 0}},
               {"kd 1 1 1\nmap_kd C:\\work\\textures\\c.png", {0, 1, 0}},
               {"", glm::vec3(0.5f)}};
  for (const auto& one : cases) {
    write("looks.mtl", std::string("newmtl wall\n") + one.looks + "\n");
    const Scene scene = read(kPlacedSquare).scene;
    EXPECT_LT(glm::length(baseColourAt(scene, 0, 0.3f, 0.3f) - one.colour), 2e-3f) << one.looks;
  }
}

}  // namespace
}  // namespace nlg
