#include "datagen/visibility/ray_scene.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "runtime_eval/numbers/random.h"
#include "tests/datagen/hand_built_scenes.h"

namespace nlg {
namespace {

// A square at x = 0 cut into random triangles that share their corners: rows of quads, corners shaken.
Scene shakenSquare(std::vector<glm::vec3>* corners) {
  constexpr int kCells = 12;
  Random random(3);
  SceneOfFaces faces;
  const auto at = [&](int i, int k) { return (*corners)[i * (kCells + 1) + k]; };
  for (int i = 0; i <= kCells; ++i) {
    for (int k = 0; k <= kCells; ++k) {
      const bool inner = i > 0 && i < kCells && k > 0 && k < kCells;
      const double shake = inner ? 0.3 : 0.0;
      corners->push_back({inner ? random.uniform(-0.1, 0.1) : 0.0, i - kCells / 2 + random.uniform(-shake, shake),
                          k - kCells / 2 + random.uniform(-shake, shake)});
    }
  }
  for (int i = 0; i < kCells; ++i) {
    for (int k = 0; k < kCells; ++k) faces.addQuad(at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1));
  }
  return faces.finish();
}

TEST(RayScene, BlocksSegmentsThatCrossAFaceFromEitherSide) {
  const RayScene scene(thinWall(Sides::one));
  EXPECT_TRUE(scene.isBlocked({0, 0, 0}, {1, 0.3f, 0.2f}));
  EXPECT_TRUE(scene.isBlocked({1, 0.3f, 0.2f}, {0, 0, 0}));
  EXPECT_FALSE(scene.isBlocked({0, 0, 0}, {0.3f, 40, 40}));
  EXPECT_FALSE(scene.isBlocked({0.32f, 0, 0}, {5, 1, 1}));
  EXPECT_FALSE(scene.isBlocked({0, 0, 0}, {-5, 0, 0})) << "the wall is behind the origin";
}

TEST(RayScene, CountsASegmentsEndsAndLetsSegmentsPassInAFacesPlane) {
  const RayScene scene(SceneOfFaces().addQuad({1, -4, -4}, {1, 4, -4}, {1, 4, 4}, {1, -4, 4}).finish());
  EXPECT_TRUE(scene.isBlocked({0, 0.25f, 0.5f}, {1, 0.25f, 0.5f}));
  EXPECT_TRUE(scene.isBlocked({1, 0.25f, 0.5f}, {2, 0.25f, 0.5f}));
  EXPECT_FALSE(scene.isBlocked({0, 0.25f, 0.5f}, {0.9999f, 0.25f, 0.5f}));
  EXPECT_FALSE(scene.isBlocked({1, -1, 0.5f}, {1, 2, 0.25f}));
}

TEST(RayScene, IsWatertightAlongSharedEdges) {
  std::vector<glm::vec3> corners;
  const Scene square = shakenSquare(&corners);
  const RayScene scene(square);
  Random random(4);
  for (int i = 0; i < 100000; ++i) {
    // a place on an inner edge, or a corner, of some triangle; a segment through it from one side to the other
    const glm::uvec3& triangle = square.triangles[random.below(static_cast<uint32_t>(square.triangles.size()))];
    const uint32_t side = random.below(3);
    const glm::vec3 a = square.positions[triangle[side]], b = square.positions[triangle[(side + 1) % 3]];
    const glm::vec3 target = i % 8 == 0 ? a : a + (b - a) * static_cast<float>(random.uniform());
    if (std::max(std::fabs(target.y), std::fabs(target.z)) > 5.5f) continue;  // the square's own border
    const glm::vec3 from = target + glm::vec3(random.uniform(0.5, 3), random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2));
    const glm::vec3 to = target + (target - from) * static_cast<float>(random.uniform(0.5, 2));
    ASSERT_TRUE(scene.isBlocked(from, to)) << "segment " << i << " through " << target.x << ' ' << target.y << ' ' << target.z;
  }
}

TEST(RayScene, TellsWhichSideOfTheFirstFaceARayMeets) {
  SceneOfFaces faces;
  faces.addBox({1, -1, -1}, {2, 1, 1});
  faces.addQuad({-1, -1, -1}, {-1, -1, 1}, {-1, 1, 1}, {-1, 1, -1}, Sides::two);
  const RayScene scene(faces.finish());
  EXPECT_EQ(scene.firstFacing({0, 0.1f, 0.2f}, {1, 0, 0}), Facing::front);
  EXPECT_EQ(scene.firstFacing({1.5f, 0.1f, 0.2f}, {1, 0, 0}), Facing::back);
  EXPECT_EQ(scene.firstFacing({1.5f, 0.1f, 0.2f}, {-1, 0, 0}), Facing::back);
  EXPECT_EQ(scene.firstFacing({0, 0.1f, 0.2f}, {-1, 0, 0}), Facing::both);
  EXPECT_EQ(scene.firstFacing({0, 0.1f, 0.2f}, {0, 1, 0}), Facing::nothing);
}

TEST(RayScene, TakesCoincidentFacesThatDisagreeForNoEvidence) {
  // a box that rests on another: the faces in between look both ways
  SceneOfFaces faces;
  faces.addBox({-1, -2, -1}, {1, -1, 1});
  faces.addBox({-1, -1, -1}, {1, 0, 1});
  const RayScene scene(faces.finish());
  EXPECT_EQ(scene.firstFacing({0.1f, -0.5f, 0.2f}, {0, -1, 0}), Facing::both);
  EXPECT_EQ(scene.firstFacing({0.1f, -1.5f, 0.2f}, {0, 1, 0}), Facing::both);
  EXPECT_EQ(scene.firstFacing({0.1f, -0.5f, 0.2f}, {0, 1, 0}), Facing::back);
  EXPECT_EQ(scene.firstFacing({0.1f, 0.5f, 0.2f}, {0, -1, 0}), Facing::front);
  // two faces in one place that agree are one
  faces.addBox({-1, -1, -1}, {1, 0, 1});
  EXPECT_EQ(RayScene(faces.finish()).firstFacing({0.1f, 0.5f, 0.2f}, {0, -1, 0}), Facing::front);
}

TEST(RayScene, FindsEveryTriangleNearACube) {
  SceneOfFaces faces;
  for (int i = 0; i < 1000; ++i) faces.addBox({3.0f * i, 10, 10}, {3.0f * i + 1, 11, 11});
  faces.addTriangle({500, 0.99f, 0}, {500.01f, 0.99f, 0}, {500, 0.99f, 0.01f});
  faces.addTriangle({-5000, 0.5f, -5000}, {5000, 0.5f, -5000}, {0, 0.5f, 9000});
  const RayScene scene(faces.finish());
  std::vector<uint32_t> found;
  scene.trianglesNearCube({500, 0, 0}, 1, &found);
  EXPECT_EQ(found, (std::vector<uint32_t>{12000, 12001}));
  scene.trianglesNearCube({500, -20, 0}, 1, &found);
  EXPECT_TRUE(found.empty());
}

TEST(RayScene, AThinTransmissiveSurfaceIsAirForFunctionsAndADenseOneASheet) {
  for (const Transmissive transmissive : {Transmissive::none, Transmissive::thin, Transmissive::dense}) {
    Scene scene = SceneOfFaces().addQuad({-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}).finish();
    scene.materials[0].transmissive = transmissive;
    scene.materials[0].double_sided = true;
    const RayScene rays(scene);
    std::vector<uint32_t> near;
    rays.trianglesNearCube({0, 0, 0}, 1.0f, &near);
    EXPECT_EQ(near.size(), transmissive == Transmissive::thin ? 0u : 2u);
    EXPECT_EQ(rays.isBlocked({0.1f, 1, 0}, {0.1f, -1, 0}), transmissive != Transmissive::thin);
    EXPECT_EQ(rays.firstFacing({0.1f, 1, 0}, {0, -1, 0}), transmissive == Transmissive::thin ? Facing::nothing : Facing::both);
    EXPECT_EQ(rays.isOpaqueBetween({0.1f, 1, 0}, {0.1f, -1, 0}), transmissive == Transmissive::none);
    EXPECT_EQ(rays.lightHit({0.1f, 1, 0}, {0, -1, 0}).kind,
              transmissive == Transmissive::none ? LightHit::Kind::surface : LightHit::Kind::nothing);
    const LightHit met = rays.transmissiveHit({0.1f, 1, 0}, {0, -1, 0}, 0.0f, 2.0f);
    EXPECT_EQ(met.kind, transmissive == Transmissive::none ? LightHit::Kind::nothing : LightHit::Kind::surface);
    if (transmissive == Transmissive::none) continue;
    EXPECT_FLOAT_EQ(met.distance, 1.0f);
    EXPECT_EQ(rays.transmissiveHit({0.1f, 1, 0}, {0, -1, 0}, RayScene::justBehind(met), 2.0f).kind, LightHit::Kind::nothing);
  }
}

// Lava's surface in a level, or a sheet with a face for each side: which of them the traversal meets first says nothing.
TEST(RayScene, LightMeetsTheFaceTowardsItOfTwoInOnePlace) {
  SceneOfFaces faces;
  faces.addRoom({-8, -1, -8}, {8, 8, 8}, 0.2f);
  SkyFaces lava;
  const auto add = [](std::vector<glm::uvec3>* triangles, uint32_t first) {
    for (const glm::uvec3 corners : {glm::uvec3(0, 1, 2), glm::uvec3(0, 2, 3)}) triangles->push_back(corners + first);
  };
  for (int i = 0; i < 16; ++i) {
    const float x = -6.0f + static_cast<float>(i % 4) * 3.0f, z = -6.0f + static_cast<float>(i / 4) * 3.0f;
    const glm::vec3 a(x, 0, z), b(x, 0, z + 2), c(x + 2, 0, z + 2), d(x + 2, 0, z);
    if (i % 2 == 0) {
      faces.addQuad(a, b, c, d).addQuad(a, d, c, b);
      continue;
    }
    const auto first = static_cast<uint32_t>(lava.positions.size());
    // parted along the other diagonal, as a compiler may part its other side
    lava.positions.insert(lava.positions.end(), {a, b, c, d, b, a, d, c});
    add(&lava.triangles, first);
    add(&lava.triangles, first + 4);
  }
  lava.shine.assign(lava.triangles.size(), glm::vec3(1.0f));
  Scene scene = faces.finish();
  scene.light.sky_faces = lava;
  const RayScene rays(scene);
  Random random(5);
  for (int i = 0; i < 20000; ++i) {
    const int quad = static_cast<int>(random.below(16));
    const glm::vec3 target(-6.0f + static_cast<float>(quad % 4) * 3.0f + static_cast<float>(random.uniform(0.05, 1.95)), 0.0f,
                           -6.0f + static_cast<float>(quad / 4) * 3.0f + static_cast<float>(random.uniform(0.05, 1.95)));
    const float height = i % 2 == 0 ? 3.0f : -0.5f;
    const glm::vec3 from(target.x + static_cast<float>(random.uniform(-1.0, 1.0)), height,
                         target.z + static_cast<float>(random.uniform(-1.0, 1.0)));
    const LightHit hit = rays.lightHit(from, glm::normalize(target - from));
    ASSERT_EQ(hit.kind, quad % 2 == 0 ? LightHit::Kind::surface : LightHit::Kind::sky) << i;
    ASSERT_TRUE(hit.is_front) << i;
    ASSERT_NEAR(hit.distance, glm::distance(from, target), 1e-3f) << i;
  }
}

}  // namespace
}  // namespace nlg
