#include "scene/jitter.h"

#include <gtest/gtest.h>

#include "scene/solid/closed_shells.h"

#include <algorithm>
#include <cmath>

#include "scene/procedural/procedural.h"
#include "tests/scene/scene_triangles.h"

namespace nlg {
namespace {

void addTetrahedron(Scene& scene, const glm::vec3& at, float size) {
  const auto base = static_cast<uint32_t>(scene.positions.size());
  for (const glm::vec3& corner : {glm::vec3(0, 0, 0), {1, 0, 0}, {0, 1, 0}, {0, 0, 1}})
    scene.positions.push_back(at + size * corner);
  for (const glm::uvec3& t : {glm::uvec3(0, 2, 1), {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}) scene.triangles.push_back(t + base);
  scene.triangle_material.resize(scene.triangles.size(), 0);
}

// A large piece of structure, one object of three pieces, and one whole object.
Scene makeScene() {
  Scene scene;
  scene.id = "three";
  scene.materials.emplace_back();
  addTetrahedron(scene, {0, 0, 0}, 20.0f);
  for (const float x : {2.0f, 5.0f, 8.0f}) addTetrahedron(scene, {x, 0, 2}, 1.0f);
  addTetrahedron(scene, {2, 0, 8}, 1.0f);
  scene.objects = {{"shell", 0, 4, false}, {"pieces", 4, 12, true}, {"whole", 16, 4, true}};
  return scene;
}

TEST(SplitConnectedComponents, SeparatesWhatSharesNoPositionAndHoldsLargePiecesForStructure) {
  Scene scene = makeScene();
  scene.objects[0].movable = true;
  splitConnectedComponents(scene, 0.35);
  ASSERT_EQ(scene.objects.size(), 5u);
  for (uint32_t i = 0; i < 5; ++i) {
    EXPECT_EQ(scene.objects[i].first_triangle, 4 * i);
    EXPECT_EQ(scene.objects[i].triangle_count, 4u);
    EXPECT_EQ(scene.objects[i].movable, i > 0);
  }
  EXPECT_EQ(scene.triangles.size(), 20u);
  EXPECT_EQ(scene.objects[4].name, "whole");
}

TEST(SplitConnectedComponents, JoinsVerticesThatStandAtTheSamePosition) {
  Scene scene = makeScene();
  // a second tetrahedron with one corner, by another index, where the first has one
  addTetrahedron(scene, {2, 0, 9}, 1.0f);
  scene.objects.back().triangle_count = 8;
  splitConnectedComponents(scene, 0.35);
  EXPECT_EQ(scene.objects.size(), 5u);
  EXPECT_EQ(scene.objects.back().triangle_count, 8u);
}

TEST(Jitter, IsAPureFunctionOfItsArgumentsAndTheSceneItselfForZero) {
  const Scene scene = makeProceduralScene("house", 3), same = jitterScene(scene, {}, 0);
  EXPECT_EQ(same.positions, scene.positions);
  EXPECT_EQ(same.triangles, scene.triangles);
  EXPECT_EQ(same.objects.size(), scene.objects.size());
  for (const uint64_t jitter : {1, 2, 99})
    EXPECT_EQ(jitterScene(scene, {}, jitter).positions, jitterScene(scene, {}, jitter).positions) << jitter;
  EXPECT_NE(jitterScene(scene, {}, 1).positions, jitterScene(scene, {}, 2).positions);
}

TEST(Jitter, LeavesStructureWhereItIs) {
  const Scene scene = makeScene(), moved = jitterScene(scene, {}, 5);
  ASSERT_EQ(moved.objects[0].name, "shell");
  for (size_t i = 0; i < 4; ++i) {
    for (int k = 0; k < 3; ++k) EXPECT_EQ(corner(moved, i, k), corner(scene, i, k));
  }
}

TEST(Jitter, MovesTurnsAndScalesWithinItsOptions) {
  const Scene scene = makeScene();
  JitterOptions options;
  options.drop_share = 0.0;
  Scene parts = scene;
  splitConnectedComponents(parts, options.structure_share);
  for (uint64_t jitter = 1; jitter <= 50; ++jitter) {
    const Scene moved = jitterScene(scene, options, jitter);
    ASSERT_EQ(moved.objects.size(), parts.objects.size());
    for (size_t i = 1; i < moved.objects.size(); ++i) {
      const double scale = std::cbrt(volumeOf(moved, moved.objects[i]) / volumeOf(parts, parts.objects[i]));
      EXPECT_GE(scale, 0.85 - 1e-4) << "jitter " << jitter;
      EXPECT_LE(scale, 1.15 + 1e-4) << "jitter " << jitter;
      // the point at the box's lower corner lies sqrt(1/2) from the axis: it turns by at most 20 degrees and grows by 15 %
      const uint32_t corner = moved.triangles[moved.objects[i].first_triangle].x;
      const uint32_t before = parts.triangles[parts.objects[i].first_triangle].x;
      const glm::vec3 shift = moved.positions[corner] - parts.positions[before];
      EXPECT_LE(std::abs(shift.x), 0.5 + 0.5) << "jitter " << jitter;
      EXPECT_LE(std::abs(shift.z), 0.5 + 0.5) << "jitter " << jitter;
      EXPECT_LE(std::abs(shift.y), 0.05 + 0.5 * 0.15 + 1e-5) << "jitter " << jitter;
    }
  }
}

TEST(Jitter, DropsItsShareOfMovableObjects) {
  const Scene scene = makeScene();
  size_t kept = 0;
  constexpr size_t kDraws = 2000;
  for (uint64_t jitter = 1; jitter <= kDraws; ++jitter) kept += jitterScene(scene, {}, jitter).objects.size() - 1;
  // 4 x 2000 draws at 0.9: five standard deviations are 0.017
  EXPECT_NEAR(static_cast<double>(kept) / (4.0 * kDraws), 0.9, 0.017);
}

TEST(Jitter, CoversAllTrianglesWithObjectsInOrder) {
  for (const std::string& family : proceduralFamilies()) {
    const Scene moved = jitterScene(makeProceduralScene(family, 1), {}, 4);
    uint32_t next = 0;
    for (const SceneObject& object : moved.objects) {
      EXPECT_EQ(object.first_triangle, next) << family << " " << object.name;
      next += object.triangle_count;
    }
    EXPECT_EQ(next, moved.triangles.size()) << family;
    EXPECT_EQ(next, moved.triangle_material.size()) << family;
    for (const glm::uvec3& t : moved.triangles) ASSERT_LT(std::max({t.x, t.y, t.z}), moved.positions.size()) << family;
  }
}

}  // namespace
}  // namespace nlg
