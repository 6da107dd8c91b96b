#include "scene/scene_size.h"

#include <gtest/gtest.h>

#include "scene/scene_source.h"
#include "tests/input_error.h"
#include "tests/scene/gltf/gltf_parts.h"
#include "tool/error.h"

namespace nlg {
namespace {

// A triangle whose bounds are those of a box.
Scene sceneOfSize(const glm::vec3& size) {
  Scene scene;
  scene.positions = {{0, 0, 0}, {size.x, size.y, 0}, {0, 0, size.z}};
  scene.triangles = {{0, 1, 2}};
  scene.materials.resize(1);
  scene.triangle_material = {0};
  return scene;
}

std::string noteOf(const glm::vec3& size, double unit_m = 1.0) { return sizeNote(sceneOfSize(size), "room.obj", unit_m); }

std::string errorOf(const glm::vec3& size) {
  try {
    return "note: " + noteOf(size);
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST(SceneSize, BoundsWhatCountsAsACavity) {
  EXPECT_EQ(loadScene("house:3").scene.cavity_m, 0.5);
  EXPECT_EQ(loadScene("house:3", {1.0, kDenseTransmissive, 0.2}).scene.cavity_m, 0.2);
  EXPECT_EQ(loadScene("house:3", {1.0, kDenseTransmissive, 0.0}).scene.cavity_m, 0.0);
  const SceneSource box = loadScene("cornell", {1.0, kDenseTransmissive, 100.0});
  const Bounds bounds = sceneBounds(box.scene);
  const glm::vec3 sides = bounds.max - bounds.min;
  EXPECT_FLOAT_EQ(static_cast<float>(box.scene.cavity_m), 0.25f * std::min({sides.x, sides.y, sides.z}))
      << "a room is wider than four cavities";
}

TEST(SceneSize, SuggestsTheUnitOfWhatIsTooLargeOrTooSmall) {
  EXPECT_EQ(
      noteOf({500, 300, 800}),
      "at 1 m a unit it is 500 x 300 x 800 m, a size that few levels have; if it was made in centimetres, --unit 0.01 makes "
      "it 5 x 3 x 8 m");
  EXPECT_NE(noteOf({20000, 20000, 8000}).find("if it was made in millimetres, --unit 0.001 makes it 20 x 20 x 8 m"),
            std::string::npos)
      << noteOf({20000, 20000, 8000});
  EXPECT_NE(noteOf({6000, 3, 100}).find("--unit 0.01 makes it 60 x 0.03 x 1 m"), std::string::npos) << noteOf({6000, 3, 100});
  EXPECT_EQ(noteOf({0.2f, 0.1f, 0.3f}),
            "at 1 m a unit it is 0.2 x 0.1 x 0.3 m, a size that few levels have; --unit 100 makes it 20 x 10 x 30 m");
  // in centimetres its rooms would be as high as a nave
  Scene house = loadScene("house:3").scene;
  for (glm::vec3& position : house.positions) position *= 1000.0f;
  EXPECT_NE(sizeNote(house, "house.glb", 1.0).find("in millimetres, --unit 0.001"), std::string::npos)
      << sizeNote(house, "house.glb", 1.0);
}

TEST(SceneSize, RefusesWhatIsNoLevel) {
  EXPECT_EQ(errorOf({0.02f, 0.01f, 0}), "room.obj: longest side: expected 0.1 to 100000 m at 1 m a unit (--unit), got 0.02 m");
  EXPECT_EQ(errorOf({1, 200000, 1}), "room.obj: longest side: expected 0.1 to 100000 m at 1 m a unit (--unit), got 200000 m");
}

using SceneFiles = GltfFiles;

// A square of 400 units, upright: as it is, and with a unit.
TEST_F(SceneFiles, AreToldOfTheirSizeAlike) {
  Parts parts;
  parts.nodes = R"([{"mesh":0,"scale":[400,400,400]}])";
  const std::string paths[] = {write("wall.gltf", parts.text()), write("wall.glb", parts.binary()),
                               write("wall.obj", "v 0 0 0\nv 400 0 0\nv 400 400 0\nv 0 400 0\nf 1 2 3 4\n")};
  for (const std::string& path : paths) {
    const SceneSource source = loadScene(path);
    ASSERT_FALSE(source.notes.empty()) << path;
    EXPECT_NE(source.notes.back().find("at 1 m a unit it is 400 x 400 x 0 m"), std::string::npos) << source.notes.back();
    EXPECT_NE(source.unit_question, "") << "no room tells of its unit";
    const SceneSource scaled = loadScene(path, {0.01});
    for (const std::string& note : scaled.notes) EXPECT_EQ(note.find("few levels"), std::string::npos) << note;
    EXPECT_NEAR(areaOf(scaled.scene), 16.0, 1e-4) << path;
    EXPECT_NE(scaled.sha256, source.sha256) << path;
    EXPECT_THROW(loadScene(path, {1e4}), InputError) << path;
  }
}

// A room that faces in, 500 x 260 x 400 units: in centimetres, unless somebody says otherwise.
TEST_F(SceneFiles, AreReadInTheUnitThatTheirRoomsLeaveNoDoubtOf) {
  const std::string path =
      write("room.obj",
            "v 0 0 0\nv 500 0 0\nv 500 0 400\nv 0 0 400\nv 0 260 0\nv 500 260 0\nv 500 260 400\nv 0 260 400\n"
            "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  const SceneSource source = loadScene(path);
  EXPECT_EQ(source.unit_m, 0.01);
  EXPECT_EQ(source.unit_question, "");
  ASSERT_FALSE(source.notes.empty());
  EXPECT_NE(source.notes.back().find("read in centimetres"), std::string::npos) << source.notes.back();
  EXPECT_EQ(source.sha256, loadScene(path, {0.01}).sha256);
  const SceneSource metres = loadScene(path, {1.0});
  EXPECT_EQ(metres.unit_m, 1.0);
  EXPECT_EQ(metres.unit_question, "");
}

// Of a file that is not there: how it is refused.
bool isUsageError(const std::string& path, const SceneReading& reading) {
  try {
    loadScene(path, reading);
  } catch (const UsageError&) {
    return true;
  } catch (const InputError&) {
  }
  return false;
}

TEST(SceneFormats, AreKnownByTheirEndingsInAnyCaseAndKeepToTheirOptions) {
  EXPECT_EQ(formatOf("a.b/LEVEL.GLB"), formatOf("level.glb"));
  EXPECT_EQ(formatOf("house:3"), nullptr);
  SceneReading part, inches;
  part.gltf.leave_out = {"x"};
  inches.unit_m = 0.0254;
  for (const std::string ending : {".glb", ".gltf", ".obj", ".bsp"}) {
    const SceneFormat* format = formatOf("none" + ending);
    ASSERT_NE(format, nullptr) << ending;
    EXPECT_NE(sceneForms().find(ending), std::string::npos);
    // what a format does not have is refused before the file is looked for
    EXPECT_EQ(isUsageError("none" + ending, part), !format->is_gltf) << ending;
    EXPECT_EQ(isUsageError("none" + ending, inches), !format->has_unit) << ending;
  }
}

TEST_F(SceneFiles, OfOtherFormatsAreRefusedWithTheWayToOneThatIsRead) {
  for (const std::string name : {"level.fbx", "level.blend", "level.usdz", "no_such_file.dae"}) {
    expectInputError("File > Export > glTF 2.0", [&] { loadScene(write(name, "x")); });
  }
}

// A box of their author's, in units of the file: no part of the scene, wherever it stands among the nodes.
TEST_F(SceneFiles, MayNameTheBoxInWhichThingsMove) {
  Parts parts;
  parts.nodes = R"([{"mesh":0},{"name":"nlg_extent","translation":[10,0,0],"scale":[5,2,3]}])";
  parts.scenes = R"([{"nodes":[0,1]}])";
  const auto extentOf = [&](double unit_m) { return loadScene(write("box.gltf", parts.text()), {unit_m}).scene.extent; };
  ASSERT_TRUE(extentOf(1.0));
  EXPECT_EQ(extentOf(1.0)->low_m, glm::dvec3(5, -2, -3));
  EXPECT_EQ(extentOf(2.0)->high_m, glm::dvec3(30, 4, 6));
  const size_t triangles = loadScene(write("box.gltf", parts.text())).scene.triangles.size();

  // the square's own corners
  parts.nodes = R"([{"mesh":0},{"name":"room","mesh":0,"translation":[0,0,7],"extras":{"nlg_extent":true}}])";
  const SceneSource marked = loadScene(write("marked.gltf", parts.text()));
  ASSERT_TRUE(marked.scene.extent);
  EXPECT_EQ(marked.scene.triangles.size(), triangles);
  const Bounds square = sceneBounds(marked.scene);
  EXPECT_EQ(marked.scene.extent->low_m - marked.scene.origin_m, glm::dvec3(square.min) + glm::dvec3(0, 0, 7));
  EXPECT_EQ(marked.scene.extent->high_m - marked.scene.origin_m, glm::dvec3(square.max) + glm::dvec3(0, 0, 7));

  parts.nodes = R"([{"mesh":0},{"name":"nlg_extended","extras":{"nlg_extent":false}}])";
  EXPECT_FALSE(extentOf(1.0));
  // as Blender wrote true before it had booleans
  parts.nodes = R"([{"mesh":0},{"name":"room","scale":[5,2,3],"extras":{"nlg_extent":1}}])";
  EXPECT_TRUE(extentOf(1.0));
}

TEST_F(SceneFiles, MaySayHowFarApartProbesAre) {
  Parts parts;
  parts.scenes = R"([{"nodes":[0,1,2]}])";
  const auto read = [&](const std::string& first, const std::string& second) {
    parts.nodes = R"([{"mesh":0},{"translation":[10,0,0],"scale":[5,2,3],"extras":{"nlg_density":)" + first +
                  R"(}},{"mesh":0,"extras":{"nlg_density":)" + second + "}}]";
    return loadScene(write("dense.gltf", parts.text()), {2.0});
  };
  const SceneSource source = read("0.25", "0");
  ASSERT_EQ(source.scene.density.size(), 2u);
  EXPECT_EQ(source.scene.density[0].box.low_m, glm::dvec3(10, -4, -6));
  EXPECT_EQ(source.scene.density[0].spacing_m, 0.25);
  EXPECT_EQ(source.scene.density[1].spacing_m, 0.0);
  EXPECT_EQ(source.scene.triangles.size(), 2u);
  // functions depend on it
  EXPECT_NE(sceneSha256(read("0.5", "0").scene), sceneSha256(source.scene));
  // what is no spacing is left out, and said
  const SceneSource odd = read("-1", "\"fine\"");
  EXPECT_TRUE(odd.scene.density.empty());
  ASSERT_FALSE(odd.notes.empty());
  EXPECT_NE(odd.notes.front().find("nlg_density"), std::string::npos) << odd.notes.front();
}

}  // namespace
}  // namespace nlg
