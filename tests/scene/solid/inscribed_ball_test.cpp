#include "scene/solid/inscribed_ball.h"

#include <gtest/gtest.h>

#include "tests/scene/built_scenes.h"

namespace nlg {
namespace {

std::vector<Facet> facetsOf(const Scene& scene) {
  std::vector<Facet> facets;
  for (const glm::uvec3& t : scene.triangles)
    facets.push_back({scene.positions[t.x], scene.positions[t.y], scene.positions[t.z]});
  return facets;
}

bool fits(const Scene& scene, double diameter_m) {
  uint64_t cost_left = uint64_t{1} << 24;
  const std::optional<bool> answer = ballFits(facetsOf(scene), diameter_m, &cost_left);
  EXPECT_TRUE(answer.has_value());
  return answer.value_or(false);
}

Scene box(const glm::vec3& low, const glm::vec3& high) {
  Scene scene = sceneOfMaterial(true);
  addBox(scene, low, high);
  return scene;
}

TEST(InscribedBall, FitsABoxThatIsWideEnough) {
  // far from the middle of the scene, too; the search may miss what is less than a sixteenth wider
  for (const glm::vec3& at : {glm::vec3(0), glm::vec3(80, -3, 41)}) {
    EXPECT_TRUE(fits(box(at, at + glm::vec3(4, 2.5f, 3)), 0.5));
    EXPECT_TRUE(fits(box(at, at + glm::vec3(6, 0.54f, 3)), 0.5));
    EXPECT_FALSE(fits(box(at, at + glm::vec3(6, 0.49f, 3)), 0.5));
    EXPECT_FALSE(fits(box(at, at + glm::vec3(6, 0.2f, 3)), 0.5));
  }
  EXPECT_FALSE(fits(sceneOfMaterial(true), 0.5));
}

// Walls that stand aslant, and those between two surfaces.
TEST(InscribedBall, IsFoundInShellsOfAnyShape) {
  Scene slanted = box({0, 0, 0}, {6, 3, 0.2f});
  for (glm::vec3& p : slanted.positions) p = {0.8f * p.x - 0.6f * p.z, p.y + 0.3f * p.x, 0.6f * p.x + 0.8f * p.z};
  EXPECT_FALSE(fits(slanted, 0.5));
  EXPECT_TRUE(fits(slanted, 0.15));
  Scene thick = box({0, 0, 0}, {5, 3, 4});
  addRoom(thick, {0.2f, 0.2f, 0.2f}, {4.8f, 2.8f, 3.8f});
  EXPECT_FALSE(fits(thick, 0.5)) << "walls of 20 cm around a room";
  EXPECT_TRUE(fits(thick, 0.18));
  Scene niche = box({0, 0, 0}, {5, 3, 4});
  addRoom(niche, {0.2f, 0.2f, 0.2f}, {4.8f, 2.8f, 3.3f});
  EXPECT_TRUE(fits(niche, 0.5)) << "70 cm behind one of them";
}

// The winding number of a box with an open end is over a half but before the opening.
TEST(InscribedBall, DoesNotMindAHole) {
  Scene open = box({0, 0, 0}, {4, 2.5f, 3});
  open.triangles.resize(open.triangles.size() - 2);
  EXPECT_TRUE(fits(open, 0.5));
  Scene wall = box({0, 0, 0}, {4, 2.5f, 0.2f});
  wall.triangles.resize(wall.triangles.size() - 2);
  EXPECT_FALSE(fits(wall, 0.5));
}

TEST(InscribedBall, IsNotFoundInARoomTurnedInsideOut) {
  Scene room = sceneOfMaterial(true);
  addRoom(room, {0, 0, 0}, {4, 2.5f, 3});
  EXPECT_FALSE(fits(room, 0.5));
}

TEST(InscribedBall, HasNoAnswerWhereItMayNotLook) {
  uint64_t cost_left = 10;
  EXPECT_FALSE(ballFits(facetsOf(box({0, 0, 0}, {4, 3, 4})), 0.5, &cost_left).has_value());
  EXPECT_EQ(cost_left, 0u);
}

}  // namespace
}  // namespace nlg
