#include "validate/light/rooms.h"

#include <gtest/gtest.h>

#include "light/air.h"
#include "runtime_eval/numbers/random.h"
#include "scene/procedural/procedural.h"

namespace nlg {
namespace {

std::vector<glm::dvec3> placesInAir(const Scene& scene, const RayScene& rays, size_t count) {
  const ExtentBox extent = lightExtent(scene, {});
  Random random(1);
  std::vector<glm::dvec3> places;
  while (places.size() < count) {
    glm::dvec3 at;
    for (int axis = 0; axis < 3; ++axis) at[axis] = random.uniform(extent.low_m[axis], extent.high_m[axis]);
    if (isInAir(rays, at)) places.push_back(at);
  }
  return places;
}

struct Box {
  glm::dvec3 low, high;
  bool holds(const glm::dvec3& at) const { return glm::all(glm::greaterThan(at, low)) && glm::all(glm::lessThan(at, high)); }
};

// What of the boxes, or outside of all, a place lies in.
size_t boxOf(const std::vector<Box>& boxes, const glm::dvec3& at) {
  return static_cast<size_t>(std::find_if(boxes.begin(), boxes.end(), [&](const Box& box) { return box.holds(at); }) -
                             boxes.begin());
}

struct Parted {
  uint64_t seed;
  std::vector<Box> boxes;  // of rooms, by the scenes' own plans
};
const Parted kParted[] = {
    {0, {{{0, 0, 0}, {5, 3, 4}}}},
    {4, {{{0, 0, 0}, {4, 2.6, 4}}, {{0, 0, -3.65}, {4, 2.6, -0.15}}}},
    {6, {{{0, 0, 0}, {5, 2.6, 4}}, {{0, -2.4, 0}, {5, -0.2, 4}}}},
    {8, {{{0, 0, 0}, {4, 2.6, 4}}, {{4.1, 0, 0}, {7.1, 2.6, 4}}}},
};

// In a window, a door or close to it a place sees as much of either side: a tenth of a room may lie on the other.
TEST(Rooms, ArePartedByWallsDoorsAndWindows) {
  for (const Parted& parted : kParted) {
    SCOPED_TRACE(parted.seed);
    const Scene scene = makeBuiltInScene("daylight", parted.seed);
    const RayScene rays(scene);
    const std::vector<glm::dvec3> places = placesInAir(scene, rays, 1500);
    const std::vector<SeenRoom> rooms = findRooms(rays, places, {});
    std::vector<size_t> found(parted.boxes.size() + 1);
    for (const SeenRoom& room : rooms) {
      std::vector<size_t> counts(parted.boxes.size() + 1);
      for (const uint32_t place : room.places) ++counts[boxOf(parted.boxes, places[place])];
      const auto most = std::max_element(counts.begin(), counts.end());
      EXPECT_GE(static_cast<double>(*most), 0.9 * static_cast<double>(room.places.size())) << room.places.size();
      ++found[static_cast<size_t>(most - counts.begin())];
    }
    for (size_t box = 0; box < parted.boxes.size(); ++box) EXPECT_EQ(found[box], 1u) << "room " << box;
    EXPECT_GE(found.back(), 1u) << "outside";
  }
}

TEST(Rooms, HoldEveryPlaceOnceButForAFewThatSeeNone) {
  const Scene scene = makeBuiltInScene("daylight", 4);
  const RayScene rays(scene);
  const std::vector<glm::dvec3> places = placesInAir(scene, rays, 1500);
  RoomOptions options;
  options.most_places = 1000;
  const std::vector<SeenRoom> rooms = findRooms(rays, places, options);
  std::vector<int> count(places.size());
  for (const SeenRoom& room : rooms) {
    for (const uint32_t place : room.places) ++count[place];
    EXPECT_TRUE(std::is_sorted(room.places.begin(), room.places.end()));
    EXPECT_TRUE(isInAir(rays, room.middle_m));
  }
  EXPECT_EQ(std::count_if(count.begin(), count.end(), [](int n) { return n > 1; }), 0);
  EXPECT_LE(std::count(count.begin(), count.end(), 0), 15);
  const std::vector<uint32_t> by_place = roomOfPlaces(rooms, places.size());
  for (size_t i = 0; i < places.size(); ++i) EXPECT_EQ(by_place[i] < rooms.size(), count[i] == 1);
}

}  // namespace
}  // namespace nlg
