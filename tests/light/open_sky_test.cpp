#include "light/air.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scene/procedural/procedural.h"
#include "tests/datagen/hand_built_scenes.h"

namespace nlg {
namespace {

TEST(OpenShare, IsAllOfAPlainAndNothingOfAFloorUnderARoof) {
  SceneOfFaces plain;
  plain.addQuad({-9, 0, 9}, {9, 0, 9}, {9, 0, -9}, {-9, 0, -9});
  EXPECT_EQ(openShare(plain.finish()), 1.0);
  SceneOfFaces room;
  room.addRoom({-2, -1, -3}, {2, 1.5f, 3}, 0.2f);
  const Scene closed = room.finish();
  // the floor has nothing; the tops of the walls, 4.4 x 6.4 without 4 x 6, stand on no floor and have all
  EXPECT_NEAR(openShare(closed), 4.16 / 28.16, 0.03);
}

TEST(OpenShare, OfAStripBetweenWallsIsTheFormFactorOfTheOpening) {
  SceneOfFaces faces;
  faces.addQuad({-1, 0, 500}, {1, 0, 500}, {1, 0, -500}, {-1, 0, -500});
  for (const float x : {-1.0f, 1.0f}) faces.addQuad({x, 0, 500}, {x, 2, 500}, {x, 2, -500}, {x, 0, -500});
  // the form factor between a strip of width w and an equal one a height h above: sqrt(1 + (h/w)^2) - h/w, of h = w
  EXPECT_NEAR(openShare(faces.finish()), std::sqrt(2.0) - 1.0, 0.02);
}

TEST(OpenShare, ALandIsOpenAndAHouseIsNot) {
  EXPECT_GT(openShare(makeProceduralScene("outdoor", 3)), kOpenShare);
  EXPECT_LT(openShare(makeProceduralScene("house", 3)), kOpenShare);
  EXPECT_LT(openShare(makeProceduralScene("cave", 3)), kOpenShare);
  EXPECT_LT(openShare(makeBuiltInScene("cornell", 0)), kOpenShare);
  EXPECT_LT(openShare(makeBuiltInScene("two_rooms", 1)), kOpenShare);
}

// A box whose faces look outward: only its roof faces up. Artists make rooms of such boxes, and the lamp says that one is meant.
TEST(OpenShare, IsNothingWhereAllLampsAreIndoors) {
  SceneOfFaces faces;
  faces.addBox({-2, 0, -2}, {2, 3, 2});
  Scene scene = faces.finish();
  EXPECT_GT(openShare(scene), kOpenShare);
  Lamp lamp;
  lamp.position = {0, 2, 0};
  scene.light.lamps.push_back(lamp);
  EXPECT_EQ(openShare(scene), 0.0);
  lamp.position = {4, 2, 0};
  scene.light.lamps.push_back(lamp);
  EXPECT_GT(openShare(scene), kOpenShare);
}

}  // namespace
}  // namespace nlg
