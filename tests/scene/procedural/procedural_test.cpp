#include "scene/procedural/procedural.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "runtime_eval/numbers/random.h"
#include "tests/input_error.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr uint64_t kSeedCount = 6;

uint64_t hashOf(const Scene& scene) {
  uint64_t hash = mixSeed(scene.positions.size(), scene.triangles.size(), scene.objects.size());
  for (const glm::vec3& p : scene.positions) {
    hash = mixSeed(hash, std::bit_cast<uint32_t>(p.x), std::bit_cast<uint32_t>(p.y), std::bit_cast<uint32_t>(p.z));
  }
  for (const glm::uvec3& t : scene.triangles) hash = mixSeed(hash, t.x, t.y, t.z);
  for (const uint32_t material : scene.triangle_material) hash = mixSeed(hash, material);
  return hash;
}

// Calls check(scene) for some seeds of every family, with the scene's id in every message.
template <class Check>
void forEachScene(Check check) {
  for (const std::string& family : proceduralFamilies()) {
    for (uint64_t seed = 0; seed < kSeedCount; ++seed) {
      const Scene scene = makeProceduralScene(family, seed);
      SCOPED_TRACE(scene.id);
      check(scene);
    }
  }
}

// The same for the rooms beside daylight, which are no family to train on.
template <class Check>
void forEachDaylight(Check check) {
  for (uint64_t seed = 0; seed < kDaylightSeeds; ++seed) {
    const Scene scene = makeBuiltInScene("daylight", seed);
    SCOPED_TRACE(scene.id);
    check(scene);
  }
}

// Sheets are no surfaces of solids: they are open, and face both ways.
bool isOfSheets(const Scene& scene, const SceneObject& object) {
  return scene.materials[scene.triangle_material[object.first_triangle]].double_sided;
}

double signedVolume(const Scene& scene, const SceneObject& object) {
  double volume = 0.0;
  for (uint32_t i = 0; i < object.triangle_count; ++i) {
    const glm::uvec3& t = scene.triangles[object.first_triangle + i];
    const glm::dvec3 a(scene.positions[t.x]);
    volume += glm::dot(a, glm::cross(glm::dvec3(scene.positions[t.y]), glm::dvec3(scene.positions[t.z]))) / 6.0;
  }
  return volume;
}

// Directed edges without their opposites; none when the object's surface is closed.
size_t openEdgeCount(const Scene& scene, const SceneObject& object) {
  std::map<std::pair<uint32_t, uint32_t>, int> balance;
  for (uint32_t i = 0; i < object.triangle_count; ++i) {
    const glm::uvec3& t = scene.triangles[object.first_triangle + i];
    for (int corner = 0; corner < 3; ++corner) {
      const uint32_t a = t[corner];
      const uint32_t b = t[(corner + 1) % 3];
      balance[std::minmax(a, b)] += a < b ? 1 : -1;
    }
  }
  size_t count = 0;
  for (const auto& [edge, sum] : balance) count += sum != 0;
  return count;
}

TEST(ProceduralScene, IsTheSameForTheSameSeed) {
  for (const std::string& family : proceduralFamilies()) {
    EXPECT_EQ(hashOf(makeProceduralScene(family, 7)), hashOf(makeProceduralScene(family, 7))) << family;
  }
}

TEST(ProceduralScene, RefusesAnUnknownFamilyByNamingTheKnownOnes) {
  const std::string error = errorOfCall<UsageError>([] { makeProceduralScene("castle", 1); });
  for (const char* family : {"colonnade", "castle"}) EXPECT_NE(error.find(family), std::string::npos) << error;
}

TEST(ProceduralScene, HasFinitePositionsAndIndicesInRange) {
  const auto check = [](const Scene& scene) {
    ASSERT_EQ(scene.triangles.size(), scene.triangle_material.size());
    for (const glm::vec3& p : scene.positions) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
    for (const glm::uvec3& t : scene.triangles) ASSERT_LT(std::max({t.x, t.y, t.z}), scene.positions.size());
    for (const uint32_t material : scene.triangle_material) ASSERT_LT(material, scene.materials.size());
  };
  forEachScene(check);
  forEachDaylight(check);
}

TEST(ProceduralScene, CoversAllTrianglesWithObjectsInOrder) {
  forEachScene([](const Scene& scene) {
    uint32_t next = 0;
    size_t movable_count = 0;
    for (const SceneObject& object : scene.objects) {
      EXPECT_EQ(object.first_triangle, next) << object.name;
      EXPECT_GT(object.triangle_count, 0u) << object.name;
      next += object.triangle_count;
      movable_count += object.movable;
    }
    EXPECT_EQ(next, scene.triangles.size());
    EXPECT_GT(movable_count, 2u);
    EXPECT_LT(movable_count, scene.objects.size());
  });
}

TEST(ProceduralScene, HasNoDegenerateTriangles) {
  const auto check = [](const Scene& scene) {
    for (size_t i = 0; i < scene.triangles.size(); ++i) {
      const glm::uvec3& t = scene.triangles[i];
      const glm::dvec3 a(scene.positions[t.x]);
      const glm::dvec3 normal = glm::cross(glm::dvec3(scene.positions[t.y]) - a, glm::dvec3(scene.positions[t.z]) - a);
      // positions are multiples of 2^-10 m, so twice an area is zero or at least 2^-20 m2
      ASSERT_GE(glm::length(normal), 0x1p-20) << "triangle " << i;
    }
  };
  forEachScene(check);
  forEachDaylight(check);
}

TEST(ProceduralScene, HasClosedObjects) {
  const auto check = [](const Scene& scene) {
    for (const SceneObject& object : scene.objects) {
      if (isOfSheets(scene, object)) continue;
      EXPECT_EQ(openEdgeCount(scene, object), 0u) << object.name;
    }
  };
  forEachScene(check);
  forEachDaylight(check);
}

// A cave's shell looks into its air: the only object whose volume is negative.
TEST(ProceduralScene, FacesOutwards) {
  forEachScene([](const Scene& scene) {
    for (const SceneObject& object : scene.objects) {
      if (isOfSheets(scene, object)) continue;
      const double volume = signedVolume(scene, object);
      if (object.name == "cave") {
        EXPECT_LT(volume, -50.0);
      } else {
        EXPECT_GT(volume, 0.0) << object.name;
      }
    }
  });
}

int thinAxis(const Bounds& b) { return b.max.x - b.min.x < b.max.z - b.min.z ? 0 : 2; }

// 3 to 8 cm, of which skirtings take half a centimetre, or two and a half as seen from their other face; a sheet lies in the middle of
// 2 cm. Vertices are rounded to 1 mm, boards to 4.
TEST(FittedRooms, GalleriesHangPanelsAFewCentimetresBeforeTheirWalls) {
  for (uint64_t seed = 0; seed < 2 * kSeedCount; ++seed) {
    const Scene scene = makeProceduralScene("gallery", seed);
    std::vector<float> faces[3];  // of walls, by axis
    for (const SceneObject& object : scene.objects) {
      if (object.name != "skirting" && object.name != "wall") continue;
      const Bounds bounds = objectBounds(scene, object);
      const int axis = thinAxis(bounds);
      faces[axis].insert(faces[axis].end(), {bounds.min[axis], bounds.max[axis]});
    }
    size_t panel_count = 0;
    for (const SceneObject& object : scene.objects) {
      if (object.name != "panel") continue;
      ++panel_count;
      const Bounds panel = objectBounds(scene, object);
      const int axis = thinAxis(panel);
      EXPECT_LE(panel.max[axis] - panel.min[axis], 0.025f);
      float least = 1.0f;
      for (const float face : faces[axis]) {
        const float gap = std::max(face - panel.max[axis], panel.min[axis] - face);
        if (gap > 0.0f) least = std::min(least, gap);
      }
      EXPECT_GE(least, 0.005f);
      EXPECT_LE(least, 0.095f);
    }
    EXPECT_GE(panel_count, 8u) << seed;
  }
}

// Both kinds of plates are there, and what is of sheets has no thickness.
TEST(FittedRooms, AreOfBoardsOrOfSheets) {
  for (const char* family : {"kitchen", "gallery", "meeting"}) {
    std::set<bool> kinds;
    for (uint64_t seed = 0; seed < 2 * kSeedCount; ++seed) {
      const Scene scene = makeProceduralScene(family, seed);
      EXPECT_EQ(scene.viewpoints.size(), 3u) << scene.id;
      const auto plates = std::find_if(scene.objects.begin(), scene.objects.end(), [](const SceneObject& object) {
        return object.name == "panel" || object.name == "front";
      });
      ASSERT_NE(plates, scene.objects.end()) << scene.id;
      kinds.insert(isOfSheets(scene, *plates));
    }
    EXPECT_EQ(kinds.size(), 2u) << family << ": all alike, as one in 2^11 would be by chance";
  }
}

TEST(DaylightScene, FacesOutwardsAndDiffersBySeed) {
  std::set<uint64_t> hashes;
  forEachDaylight([&](const Scene& scene) {
    for (const SceneObject& object : scene.objects) EXPECT_GT(signedVolume(scene, object), 0.0) << object.name;
    EXPECT_TRUE(hashes.insert(hashOf(scene)).second);
    EXPECT_EQ(scene.viewpoints.size(), 2u);
  });
  EXPECT_THROW(makeBuiltInScene("daylight", kDaylightSeeds), UsageError);
}

// The first one holds nothing but its ground and its house, whose volume says how large the room is and that the walls are solid:
// 5.4 x 3.4 x 4.4 m less 5 x 3 x 4 m, less the window in its wall. Every side is rounded to 1/256 m, each wall's by .8 mm of 20 cm.
TEST(DaylightScene, TheFirstIsOneRoomWithWallsOf20cmAndAWindow) {
  const Scene scene = makeBuiltInScene("daylight", 0);
  ASSERT_EQ(scene.objects.size(), 2u);
  EXPECT_EQ(scene.objects[1].name, "house");
  const double expected = 5.4 * 3.4 * 4.4 - 5.0 * 3.0 * 4.0 - 1.2 * 1.2 * 0.2;
  EXPECT_NEAR(signedVolume(scene, scene.objects[1]), expected, 0.01 * expected);
  EXPECT_EQ(scene.light.suns.size(), 1u);
  EXPECT_TRUE(scene.light.lamps.empty());
}

TEST(ProceduralScene, HasTheSizeOfALevel) {
  forEachScene([](const Scene& scene) {
    const Bounds bounds = sceneBounds(scene);
    const glm::vec3 size = bounds.max - bounds.min;
    EXPECT_GE(std::max(size.x, size.z), 9.0f);
    EXPECT_LE(std::max(size.x, size.z), 40.0f);
    EXPECT_GE(size.y, 2.5f);
    EXPECT_LE(size.y, 15.0f);
    EXPECT_GE(scene.triangles.size(), 300u);
    EXPECT_LE(scene.triangles.size(), 60000u);
  });
}

}  // namespace
}  // namespace nlg
