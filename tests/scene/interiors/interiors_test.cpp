#include "scene/interiors/interiors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "datagen/probes/probe_placement.h"
#include "scene/interiors/furnisher.h"
#include "scene/scene_source.h"
#include "tests/scene/scene_triangles.h"
#include "tiny_library.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr const char* kFurnitureFolder = "/usr/share/sweethome3d/furniture";

using Build = void (*)(Home&);
const std::vector<std::pair<std::string, Build>>& plans() {
  static const std::vector<std::pair<std::string, Build>> all = {
      {"flat", buildFlat}, {"townhouse", buildTownhouse}, {"office", buildOffice}, {"villa", buildVilla}};
  return all;
}

class Interiors : public testing::Test {
 protected:
  Interiors() : path_(writeTinyLibrary(folder_)), library_(path_) {}

  TemporaryFolder folder_;
  std::string path_;
  FurnitureLibrary library_;
};

TEST_F(Interiors, AreTheSameBitsForTheSameRequest) {
  for (const std::string& plan : interiorPlans()) {
    const Interior a = makeInterior(path_, plan, 3), b = makeInterior(path_, plan, 3), other = makeInterior(path_, plan, 4);
    EXPECT_EQ(a.scene.id, plan + "_3_tiny");
    EXPECT_EQ(sceneLightSha256(a.scene), sceneLightSha256(b.scene)) << plan;
    EXPECT_NE(sceneSha256(a.scene), sceneSha256(other.scene)) << plan;
  }
}

TEST_F(Interiors, OfEveryPlanHoldFurnitureLampsAndProbes) {
  for (const std::string& plan : interiorPlans()) {
    const Scene scene = makeInterior(path_, plan, 1).scene;
    std::set<std::string> names;
    for (const SceneObject& object : scene.objects) names.insert(object.name);
    for (const char* name : {"Bookcase", "Chair", "Table", "Hanging light", "door", "shell", "window frame"})
      EXPECT_TRUE(names.count(name)) << plan << " without " << name;
    EXPECT_FALSE(scene.light.lamps.empty()) << plan;
    EXPECT_GT(placeProbes(scene, {}, 1).probeCount(), 200u) << plan;
    const Bounds bounds = sceneBounds(scene);
    const glm::vec3 size = bounds.max - bounds.min;
    EXPECT_LT(std::max({size.x, size.y, size.z}), 40.0f) << plan;
  }
}

// Whether two boxes share more than a film of 1 cm.
bool overlap(const Bounds& a, const Bounds& b) {
  constexpr float kFilm = 0.01f;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::min(a.max[axis], b.max[axis]) - std::max(a.min[axis], b.min[axis]) <= kFilm) return false;
  }
  return true;
}

Bounds boundsOf(const Box& box) {
  return {glm::vec3(box.area.x0, box.low, box.area.z0), glm::vec3(box.area.x1, box.high, box.area.z1)};
}

// Pieces of the library; what the house itself is made of is not among them.
std::vector<std::pair<std::string, Bounds>> furnitureOf(const Scene& scene) {
  std::set<std::string> names;
  for (const TinyPiece& piece : tinyPieces()) names.insert(piece.name);
  names.erase("Exterior door");
  std::vector<std::pair<std::string, Bounds>> found;
  for (const SceneObject& object : scene.objects) {
    if (names.count(object.name)) found.emplace_back(object.name, objectBounds(scene, object));
  }
  return found;
}

TEST_F(Interiors, HaveFurnitureInRoomsAndNotInEachOtherNorInDoorways) {
  for (const auto& [plan, build] : plans()) {
    for (uint64_t seed = 0; seed < 6; ++seed) {
      Home home(seed, library_);
      build(home);
      const auto furniture = furnitureOf(home.level.mesh.finish(plan));
      EXPECT_GT(furniture.size(), 10u) << plan << " " << seed;
      for (size_t i = 0; i < furniture.size(); ++i) {
        const auto& [name, box] = furniture[i];
        // the hall of a villa has lamps below its roof
        const bool is_high = name == "Hanging light" && plan == "villa";
        EXPECT_TRUE(std::any_of(home.rooms.begin(), home.rooms.end(),
                                [&, &box = box](const HomeRoom& room) {
                                  constexpr float kFilm = 0.005f;
                                  const Rect& f = room.floor;
                                  return box.min.x > f.x0 - kFilm && box.max.x < f.x1 + kFilm && box.min.z > f.z0 - kFilm &&
                                         box.max.z < f.z1 + kFilm && box.min.y > room.floor_m - kFilm &&
                                         (is_high || box.max.y < room.floor_m + room.clear_m + kFilm);
                                }))
            << plan << " " << seed << ": " << name << " at " << box.min.x << " " << box.min.y << " " << box.min.z;
        for (size_t k = 0; k < i; ++k)
          EXPECT_FALSE(overlap(box, furniture[k].second)) << plan << " " << seed << ": " << name << " in " << furniture[k].first;
      }
      for (const HomeRoom& room : home.rooms) {
        for (const RoomOpening& opening : room.openings) {
          if (opening.kind == RoomOpening::Kind::window) continue;
          // lamps under the ceiling are higher than people
          constexpr double kHigh = 1.7;
          const Bounds before =
              boundsOf({room.floor.strip(opening.side, opening.from, opening.to, 0.65), opening.low, opening.low + kHigh});
          for (const auto& [name, box] : furniture) EXPECT_FALSE(overlap(before, box)) << plan << " " << seed << ": " << name;
        }
      }
    }
  }
}

TEST_F(Interiors, HaveADoorwayToEveryRoomThatIsInsideAndThinWalls) {
  for (const auto& [plan, build] : plans()) {
    for (uint64_t seed = 0; seed < 12; ++seed) {
      Home home(seed, library_);
      build(home);
      for (const HomeRoom& room : home.rooms) {
        const bool has_stairs_alone = room.use == HomeUse::attic || room.use == HomeUse::gallery || room.use == HomeUse::terrace;
        const bool has_door = std::any_of(room.openings.begin(), room.openings.end(),
                                          [](const RoomOpening& opening) { return opening.kind != RoomOpening::Kind::window; });
        EXPECT_TRUE(has_door || has_stairs_alone) << plan << " " << seed << ": use " << static_cast<int>(room.use);
      }
      EXPECT_GE(home.outer_wall_m, 0.15 - 1e-9) << plan;
      EXPECT_LE(home.outer_wall_m, 0.30 + 1e-9) << plan;
      EXPECT_GE(home.inner_wall_m, 0.07 - 1e-9) << plan;
      EXPECT_LE(home.inner_wall_m, 0.12 + 1e-9) << plan;
    }
  }
}

TEST_F(Interiors, ConsistOfShellsThatAreOneClosedSolid) {
  for (const auto& [plan, build] : plans()) {
    Home home(2, library_);
    build(home);
    finishShell(home);
    const Scene scene = home.level.mesh.finish(plan);
    const auto shell =
        std::find_if(scene.objects.begin(), scene.objects.end(), [](const SceneObject& o) { return o.name == "shell"; });
    ASSERT_NE(shell, scene.objects.end());
    EXPECT_FALSE(shell->movable);
    EXPECT_GT(volumeOf(scene, *shell), 0.0) << plan;
    glm::dvec3 area(0.0);
    for (uint32_t i = shell->first_triangle; i < shell->first_triangle + shell->triangle_count; ++i) {
      const glm::dvec3 a = scene.positions[scene.triangles[i].x], b = scene.positions[scene.triangles[i].y],
                       c = scene.positions[scene.triangles[i].z];
      area += glm::cross(b - a, c - a);
    }
    // of a closed surface the areas' vectors sum to nothing; positions are multiples of 2^-10, so that the sum is exact
    EXPECT_EQ(area, glm::dvec3(0.0)) << plan;
  }
}

TEST_F(Interiors, StandPiecesAtWallsInFreePlacesOnly) {
  Home home(1, library_);
  const size_t idx = home.addRoom(HomeUse::living, {0, 0, 4, 3}, 0.0, 2.5);
  HomeRoom& room = home.rooms[idx];
  room.kept.push_back({{0, 0, 1, 1}, 0.0, 2.0});
  const Piece piece{FurnitureUse::chest, {0.8, 0.9, 0.5}, 0.0, 0.9, nullptr, "box"};
  int count = 0;
  while (standAtWall(home, room, piece, {{}, {}, 0.4, 0.02})) ++count;
  // the room's walls are 14 m long
  EXPECT_GT(count, 3);
  EXPECT_LT(count, 14 / 0.8);
  ASSERT_EQ(room.solids.size(), static_cast<size_t>(count));
  for (size_t i = 0; i < room.solids.size(); ++i) {
    EXPECT_FALSE(room.solids[i].overlaps(room.kept[0]));
    for (size_t k = 0; k < i; ++k) EXPECT_FALSE(room.solids[i].overlaps(room.solids[k]));
    for (size_t k = 1; k < room.kept.size(); ++k) {
      EXPECT_TRUE(k == i + 1 || !room.solids[i].overlaps(room.kept[k])) << "a piece stands before another's front";
    }
  }
}

TEST(InteriorsOfSweetHome3d, AreMadeOfAnArchiveThatIsInstalled) {
  if (!std::filesystem::is_directory(kFurnitureFolder))
    GTEST_SKIP() << "no " << kFurnitureFolder << ": apt install sweethome3d-furniture";
  std::set<std::string> archives;
  for (const auto& file : std::filesystem::directory_iterator(kFurnitureFolder)) {
    if (file.path().extension() == ".sh3f") archives.insert(file.path().string());
  }
  ASSERT_FALSE(archives.empty());
  const std::string& archive = *archives.begin();
  FurnitureLibrary library(archive);
  size_t placed = 0;
  for (int use = 1; use <= static_cast<int>(FurnitureUse::garden_thing); ++use)
    placed += library.pieces(static_cast<FurnitureUse>(use)).size();
  EXPECT_GT(3 * placed, library.size()) << archive << ": the table of uses knows a third of its pieces";
  const Interior interior = makeInterior(archive, "flat", 1);
  EXPECT_GT(interior.scene.triangles.size(), 10000u) << archive;
  EXPECT_LT(interior.scene.triangles.size(), 1000000u) << archive;
}

}  // namespace
}  // namespace nlg
