#include "scene/interiors/furniture_library.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "runtime_eval/numbers/random.h"
#include "scene/obj/obj_reader.h"
#include "tests/input_error.h"
#include "tiny_library.h"

namespace nlg {
namespace {

Scene objScene(const std::string& text) {
  SceneBudget pixels = SceneBudgets().pixels;
  const auto library = [](const std::string&) { return ObjLibraryFile{"", "", {}, "is not there"}; };
  return readObjText("test.obj", text, 1.0, {library, {}, &pixels}).scene;
}

CatalogueEntry entryOf(const glm::dvec3& size_m) {
  CatalogueEntry entry;
  entry.size_m = size_m;
  return entry;
}

// A ball of this many rings and spokes, closed and wound outwards.
std::string ballObj(int rings, int spokes) {
  std::string text = "v 0 -1 0\nv 0 1 0\n";
  for (int r = 1; r < rings; ++r) {
    for (int s = 0; s < spokes; ++s) {
      const double a = 3.14159265 * r / rings, b = 2 * 3.14159265 * s / spokes;
      text += "v " + std::to_string(std::sin(a) * std::cos(b)) + " " + std::to_string(-std::cos(a)) + " " +
              std::to_string(-std::sin(a) * std::sin(b)) + "\n";
    }
  }
  const auto at = [&](int r, int s) { return std::to_string(r == 0 ? 1 : r == rings ? 2 : 3 + (r - 1) * spokes + s % spokes); };
  for (int r = 0; r < rings; ++r) {
    for (int s = 0; s < spokes; ++s) {
      if (r > 0) text += "f " + at(r, s) + " " + at(r, s + 1) + " " + at(r + 1, s) + "\n";
      if (r + 1 < rings) text += "f " + at(r, s + 1) + " " + at(r + 1, s + 1) + " " + at(r + 1, s) + "\n";
    }
  }
  return text;
}

TEST(FurnitureModel, FillsItsCataloguesBoxOnTheFloor) {
  const FurnitureModel model = fitFurnitureModel(objScene(cubeObj()), entryOf({0.5, 0.25, 2.0}));
  ASSERT_EQ(model.triangles.size(), 12u);
  glm::dvec3 low(9.0), high(-9.0);
  for (const glm::dvec3& p : model.positions) low = glm::min(low, p), high = glm::max(high, p);
  EXPECT_EQ(low, glm::dvec3(-0.25, 0.0, -1.0));
  EXPECT_EQ(high, glm::dvec3(0.25, 0.25, 1.0));
}

TEST(FurnitureModel, IsTurnedBeforeItIsScaled) {
  // a plate of 1 x 2 x 0, lying in x and z once it was turned about x
  CatalogueEntry entry = entryOf({1.0, 0.5, 2.0});
  entry.rotation = {1, 0, 0, 0, 0, 1, 0, -1, 0};
  const FurnitureModel model = fitFurnitureModel(objScene("v 0 0 0\nv 1 0 0\nv 1 2 0\nf 1 2 3\n"), entry);
  ASSERT_EQ(model.triangles.size(), 1u);
  for (const glm::dvec3& p : model.positions) EXPECT_EQ(p.y, 0.25) << "a side without extent stands in its middle";
  const glm::uvec3& t = model.triangles[0];
  const glm::dvec3 normal = glm::cross(model.positions[t.y] - model.positions[t.x], model.positions[t.z] - model.positions[t.x]);
  EXPECT_GT(normal.y, 0.0) << "its front, which looked to +z, looks up";
}

TEST(FurnitureModel, OnlyClosedComponentsThatAreWoundOutwardsAreEvidenceOfSolid) {
  const std::string cube = cubeObj();
  const auto oneSided = [](const std::string& text) {
    const FurnitureModel model = fitFurnitureModel(objScene(text), entryOf({1, 1, 1}));
    size_t count = 0;
    for (const uint32_t material : model.triangle_material) count += model.materials[material].double_sided ? 0 : 1;
    return count;
  };
  EXPECT_EQ(oneSided(cube), 12u);
  // a face less: open
  EXPECT_EQ(oneSided(cube.substr(0, cube.rfind("f "))), 0u);
  // all faces the other way round: closed and inside out
  std::string inside_out = cube;
  for (const auto& [face, turned] : {std::pair("1 4 3 2", "2 3 4 1"),
                                     {"5 6 7 8", "8 7 6 5"},
                                     {"1 2 6 5", "5 6 2 1"},
                                     {"3 4 8 7", "7 8 4 3"},
                                     {"1 5 8 4", "4 8 5 1"},
                                     {"2 3 7 6", "6 7 3 2"}}) {
    inside_out.replace(inside_out.find(face), 7, turned);
  }
  EXPECT_EQ(oneSided(inside_out), 0u);
  // one face alone the other way round
  std::string mixed = cube;
  mixed.replace(mixed.find("1 4 3 2"), 7, "2 3 4 1");
  EXPECT_EQ(oneSided(mixed), 0u);
  // a sheet beside the cube is a component of its own
  EXPECT_EQ(oneSided(cube + "v 5 0 0\nv 6 0 0\nv 6 1 0\nf 9 10 11\n"), 12u);
}

// Edges of one-sided triangles that run more often one way than the other.
size_t openEdgesOfOneSided(const FurnitureModel& model) {
  std::map<std::pair<uint32_t, uint32_t>, int> surplus;
  for (size_t i = 0; i < model.triangles.size(); ++i) {
    if (model.materials[model.triangle_material[i]].double_sided) continue;
    for (int k = 0; k < 3; ++k) {
      const uint32_t from = model.triangles[i][k], to = model.triangles[i][(k + 1) % 3];
      surplus[{std::min(from, to), std::max(from, to)}] += from < to ? 1 : -1;
    }
  }
  return static_cast<size_t>(std::count_if(surplus.begin(), surplus.end(), [](const auto& edge) { return edge.second != 0; }));
}

TEST(FurnitureModel, IsCoarsenedToTheBudget) {
  const Scene ball = objScene(ballObj(120, 120));
  ASSERT_GT(ball.triangles.size(), 5 * kModelTriangleBudget);
  const FurnitureModel model = fitFurnitureModel(ball, entryOf({1, 1, 1}));
  EXPECT_LE(model.triangles.size(), kModelTriangleBudget);
  EXPECT_GT(model.triangles.size(), kModelTriangleBudget / 4);
  // what grows together where slivers end, as at the poles, has lost faces: then it is no evidence
  EXPECT_EQ(openEdgesOfOneSided(model), 0u);
  // each step's cell is at most a twentieth, and the cells before it sum to less than 1 / 0.3 of it
  const double farthest = 1.7321 * 0.05 * (1.0 + 1.0 / 0.3);
  for (const glm::dvec3& p : model.positions) EXPECT_NEAR(glm::length(p - glm::dvec3(0, 0.5, 0)), 0.5, farthest);
}

class FurnitureLibraryTest : public testing::Test {
 protected:
  std::string errorOf(const std::string& path) const {
    return inputErrorOf([&] { const FurnitureLibrary library(path); });
  }
  TemporaryFolder folder_;
};

TEST_F(FurnitureLibraryTest, GivesPiecesByUseAndReadsTheirModelsOnce) {
  FurnitureLibrary library(writeTinyLibrary(folder_));
  ASSERT_EQ(library.pieces(FurnitureUse::bed).size(), 1u);
  EXPECT_TRUE(library.pieces(FurnitureUse::bath).empty());
  const FurnitureModel* model = library.model(library.pieces(FurnitureUse::bed)[0]);
  ASSERT_NE(model, nullptr);
  EXPECT_EQ(model->materials[0].base_color, glm::vec3(0.5f, 0.1f, 0.1f)) << "by the material library beside the model";
  EXPECT_EQ(library.model(library.pieces(FurnitureUse::bed)[0]), model);
  EXPECT_EQ(library.modelCount(), 1u);
}

TEST_F(FurnitureLibraryTest, CountsModelsThatAreNoObjFilesAsLeftOut) {
  FurnitureLibrary library(
      writeTinyLibrary(folder_, {{"Bedroom", "Bed", 160, 200, 60, "", "bed.3ds"}}, {{"models/bed.3ds", "x"}}));
  EXPECT_EQ(library.model(0), nullptr);
  EXPECT_EQ(library.tooFineCount(), 1u);
}

TEST_F(FurnitureLibraryTest, RefusesWhatIsNoLibrary) {
  EXPECT_NE(errorOf(folder_ / "missing.sh3f").find("missing.sh3f"), std::string::npos);
  EXPECT_NE(errorOf(folder_.string()).find(".sh3f files, got none"), std::string::npos);
  EXPECT_NE(errorOf(folder_.write("text.sh3f", "no archive")).find("ZIP"), std::string::npos);
  EXPECT_NE(errorOf(writeZip(folder_ / "bare.sh3f", {{"a.txt", "a"}})).find("PluginFurnitureCatalog.properties"),
            std::string::npos);
  EXPECT_NE(errorOf(writeTinyLibrary(folder_, {})).find("pieces, got none"), std::string::npos);
}

// Half of the square shows red, half green, and one red lets half of the light through.
TEST(FurnitureModel, ImagesBecomeTheirMeansAndTransmissiveSurfacesWhole) {
  Scene scene;
  scene.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  scene.triangles = {{0, 1, 2}, {0, 2, 3}};
  scene.triangle_material = {0, 0};
  scene.base_places = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
  scene.images = {{2, 1, {{255, 0, 0, 255}, {0, 255, 0, 255}}}};
  Material material;
  material.base_color = {1.0f, 0.5f, 1.0f};
  material.base_image.image = 0;
  material.transmissive = Transmissive::thin;
  material.opacity = 0.5f;
  scene.materials = {material};
  const FurnitureModel model = fitFurnitureModel(scene, entryOf({1, 1, 0.1}));
  ASSERT_EQ(model.materials.size(), 1u);
  const Material& plain = model.materials[0];
  EXPECT_LT(glm::length(plain.base_color - glm::vec3(0.5f, 0.25f, 0.0f)), 0.005f);
  EXPECT_FALSE(plain.base_image.isThere());
  EXPECT_EQ(plain.transmissive, Transmissive::none);
  EXPECT_EQ(plain.opacity, 1.0f);
}

}  // namespace
}  // namespace nlg
