#include "scene/scene_size.h"

#include <gtest/gtest.h>

#include "tests/scene/built_scenes.h"

namespace nlg {
namespace {

// A closed room that faces in, w x h x d metres, its low corner at the origin.
Scene roomOf(float w, float h, float d, bool double_sided = false) {
  Scene scene = sceneOfMaterial(double_sided);
  addRoom(scene, {0, 0, 0}, {w, h, d});
  return scene;
}

Scene openGround() {
  Scene scene = sceneOfMaterial(false);
  addQuad(scene, {0, 0, 0}, {0, 0, 10}, {10, 0, 0});
  return scene;
}

double topOf(const Scene& scene) {
  const auto reach = reachBeyondBounds(scene, 0.1);
  return reach ? reach->high_m.y : sceneBounds(scene).max.y;
}

TEST(FloorSurvey, MeasuresTheCeilingsOfRooms) {
  const Scene scene = roomOf(5, 3, 8);
  const std::vector<Floor> floors = surveyFloors(scene);
  ASSERT_EQ(floors.size(), 512u);
  for (const Floor& floor : floors) {
    EXPECT_NEAR(floor.ceiling_m, 3.0f, 1e-5f);
    EXPECT_EQ(floor.depth_m, 0.0f);
  }
  EXPECT_NEAR(medianCeiling(floors).value(), 3.0f, 1e-5f);
  EXPECT_FALSE(medianCeiling(surveyFloors(openGround()))) << "no ceiling";
  EXPECT_TRUE(surveyFloors(sceneOfMaterial(false)).empty());
}

TEST(ReachBeyondBounds, GivesAGroundHeadroomAndHoldsItsLamps) {
  Scene scene = openGround();
  EXPECT_NEAR(topOf(scene), 2.5, 1e-5);
  addBox(scene, {4, 0, 4}, {6, 0.9f, 6});
  EXPECT_NEAR(topOf(scene), 3.4, 1e-5) << "on the box stands a figure, too";
  Lamp lamp;
  lamp.position = {12, 5.9f, 5};
  scene.light.lamps.push_back(lamp);
  EXPECT_NEAR(topOf(scene), 5.9, 1e-5);
  EXPECT_NEAR(reachBeyondBounds(scene, 0.1)->high_m.x, 12.0, 1e-5);
  scene.light.lamps[0].position = {0, 1e4f, 0};
  EXPECT_NEAR(topOf(scene), 3.4, 1e-5) << "a lamp in the place of a sun";
}

TEST(ReachBeyondBounds, GivesRoofsTheMarginAloneAndNothingToARoomThatFacesIn) {
  EXPECT_FALSE(reachBeyondBounds(roomOf(5, 3, 8), 0.1));
  Scene house = roomOf(5, 2.5f, 8);
  addBox(house, {0, 2.5f, 0}, {5, 2.7f, 8});
  EXPECT_NEAR(topOf(house), 2.8, 1e-5) << "a slab over a room";
  EXPECT_NEAR(topOf(roomOf(5, 3, 8, true)), 3.1, 1e-5) << "a ceiling of both sides";
  Scene block = sceneOfMaterial(false);
  addBox(block, {0, 0, 0}, {5, 6, 5});
  EXPECT_NEAR(topOf(block), 6.1, 1e-5) << "a solid block";
}

std::string noteOf(const Scene& scene) { return sizeNote(scene, "room.glb", 1.0); }

TEST(SceneSizeByRooms, CatchesWhatIsNoHigherThanALevelMayBe) {
  EXPECT_EQ(noteOf(roomOf(5, 3, 8)), "");
  EXPECT_EQ(noteOf(roomOf(30, 35, 90)), "") << "a nave";
  // a room of 4 x 1.4 x 3 m, in centimetres: its bounds alone are a hall's
  EXPECT_EQ(noteOf(roomOf(400, 140, 300)),
            "at 1 m a unit it is 400 x 140 x 300 m, with rooms that are 140 m high, a size that few levels have; if it was made "
            "in centimetres, --unit 0.01 makes it 4 x 1.4 x 3 m");
  EXPECT_NE(noteOf(roomOf(556, 549, 559)).find("--unit 0.01 makes it 5.56 x 5.49 x 5.59 m"), std::string::npos);
  EXPECT_NE(noteOf(roomOf(2.0f, 0.03f, 3)).find("--unit 100 makes it 200 x 3 x 300 m"), std::string::npos)
      << noteOf(roomOf(2.0f, 0.03f, 3));
}

// 2.6 m by centimetres; by a stranger's inches 5.5 m are too uncertain, and of what is small nothing is certain.
TEST(SceneSizeByRooms, KnowsTheUnitOfRoomsThatAreAStoreyHighByIt) {
  EXPECT_EQ(certainUnit(roomOf(500, 260, 400)), 0.01);
  EXPECT_EQ(certainUnit(roomOf(5000, 2600, 4000)), 0.001);
  EXPECT_EQ(certainUnit(roomOf(5, 2.6f, 4)), 0.0);
  EXPECT_EQ(certainUnit(roomOf(556, 549, 559)), 0.0);
  EXPECT_EQ(certainUnit(roomOf(0.05f, 0.026f, 0.04f)), 0.0);
}

TEST(SceneSizeByRooms, TakesNoGapForARoom) {
  Scene shelf = sceneOfMaterial(false);
  for (int i = 0; i < 100; ++i) addBox(shelf, {0, 0.02f * i, 0}, {1, 0.02f * i + 0.01f, 1});
  EXPECT_EQ(noteOf(shelf), "") << "a stack of sheets, 2 m high";
}

}  // namespace
}  // namespace nlg
