#include "scene/procedural/procedural.h"

#include <gtest/gtest.h>

#include <bit>
#include <map>
#include <set>
#include <utility>

#include "runtime_eval/numbers/random.h"
#include "tests/scene/scene_triangles.h"
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
      const double volume = volumeOf(scene, object);
      if (object.name == "cave") {
        EXPECT_LT(volume, -50.0);
      } else {
        EXPECT_GT(volume, 0.0) << object.name;
      }
    }
  });
}

TEST(DaylightScene, FacesOutwardsAndDiffersBySeed) {
  std::set<uint64_t> hashes;
  forEachDaylight([&](const Scene& scene) {
    for (const SceneObject& object : scene.objects) EXPECT_GT(volumeOf(scene, object), 0.0) << object.name;
    EXPECT_TRUE(hashes.insert(hashOf(scene)).second);
    EXPECT_EQ(scene.viewpoints.size(), 2u);
  });
  EXPECT_THROW(makeBuiltInScene("daylight", kDaylightSeeds), UsageError);
}

}  // namespace
}  // namespace nlg
