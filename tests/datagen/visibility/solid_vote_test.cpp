#include "datagen/visibility/solid_vote.h"

#include <gtest/gtest.h>

#include "tests/datagen/hand_built_scenes.h"

namespace nlg {
namespace {

TEST(SolidVote, FindsAPlaceInAWallSolid) {
  const RayScene scene(infiniteWall());
  const auto at = [&](float x) { return voteAt(scene, {x, 0.013f, 0.027f}); };
  EXPECT_TRUE(at(0.4f).solid());
  EXPECT_EQ(at(0.4f).front, 0);
  EXPECT_FALSE(at(0.2f).solid());
  EXPECT_FALSE(at(0.6f).solid());
  EXPECT_FALSE(at(0.4f).disputed());
}

TEST(SolidVote, AsksMoreMembersOfAGroupWhereTheFirstLeavesDoubt) {
  std::vector<size_t> asked;
  const auto voteBelow = [&](Sides sides) {
    asked.clear();
    return groupVote(RayScene(terrainSheet(0.0f, sides)), 7, [&](size_t member) {
      asked.push_back(member);
      return glm::dvec3(0.1, -0.3, 0.2);
    });
  };
  // half of the rays meet the ground, in seven of fourteen directions
  EXPECT_TRUE(voteBelow(Sides::one).solid());
  EXPECT_EQ(asked, (std::vector<size_t>{0}));
  EXPECT_FALSE(voteBelow(Sides::two).solid()) << "no evidence is air";
  EXPECT_EQ(asked, (std::vector<size_t>{0, 2, 4, 6}));
}

// A yard whose walls and lid are sky, between halls that look inward: from high in the yard, rays that pass the sky meet the backs
// of the halls' walls.
TEST(SolidVote, TakesNoEvidenceFromBeyondTheSky) {
  SceneOfFaces faces, yard;
  const auto sides = boxSides({-2, 0, -2}, {2, 3, 2});
  for (size_t side = 0; side < 6; ++side) {
    const auto& [a, b, c, d] = sides[side];
    (side == 2 ? faces : yard).addQuad(a, d, c, b);  // the floor is none of the sky's
  }
  for (const glm::vec3 shift : {glm::vec3(-10, 0, 0), glm::vec3(10, 0, 0), glm::vec3(0, 0, -10), glm::vec3(0, 0, 10)})
    faces.addBox(shift + glm::vec3(-5, -3, -5), shift + glm::vec3(5, 12, 5), true);
  Scene scene = faces.finish();
  scene.light.sky_faces.positions = yard.finish().positions;
  scene.light.sky_faces.triangles = yard.finish().triangles;
  const RayScene rays(scene);
  const glm::dvec3 high(0.3, 2.8, 0.1);
  EXPECT_TRUE(solidVote(rays, high).solid()) << "the halls' backs are what geometry alone shows";
  EXPECT_FALSE(voteAt(rays, high).solid());
  EXPECT_TRUE(voteAt(rays, {0.3, -0.5, 0.1}).solid()) << "below the floor";
}

}  // namespace
}  // namespace nlg
