#include "datagen/visibility/hull.h"

#include <gtest/gtest.h>

#include "tests/scene/windowed_room.h"

namespace nlg {
namespace {

// A house of walls with two sides, in a wide land.
Scene closedHouse() {
  Scene scene = sceneOfMaterial(true);
  addRoom(scene, {0, 0, 0}, {4, 3, 4});
  addBox(scene, {-0.2f, -0.2f, -0.2f}, {4.2f, 3.2f, 4.2f});
  return scene;
}

TEST(Hull, HoldsWhatItsPlacesAreIn) {
  const Scene scene = closedHouse();
  const RayScene rays(scene);
  const Hull hull(rays, {{1, 1, 1}, {3, 2, 3}});
  ASSERT_TRUE(hull.isThere());
  EXPECT_TRUE(hull.holds({2, 1.5f, 2}));
  for (const glm::vec3& outside : {glm::vec3(2, 4, 2), glm::vec3(-0.4f, 1, 1), glm::vec3(4.4f, 1, 2)})
    EXPECT_FALSE(hull.holds(outside)) << outside.x << " " << outside.y << " " << outside.z;
}

TEST(Hull, IsNoneWithoutAPlaceNorAroundOneThatSeesOut) {
  const Scene house = closedHouse(), windowed = windowedRoom(true);
  const RayScene rays(house), with_window(windowed);
  EXPECT_FALSE(Hull(rays, {}).isThere());
  EXPECT_FALSE(Hull(rays, {{1, 1, 1}, {9, 1, 1}}).isThere()) << "a camera outside";
  const glm::vec3 middle = 0.5f * (glm::vec3(kRoomLow) + glm::vec3(kRoomHigh));
  EXPECT_FALSE(Hull(with_window, {middle}).isThere()) << "a window";
}

}  // namespace
}  // namespace nlg
