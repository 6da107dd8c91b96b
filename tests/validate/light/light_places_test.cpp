#include "validate/light/light_places.h"

#include <gtest/gtest.h>

#include <cmath>

#include "light/air.h"
#include "light/light_transport.h"
#include "scene/procedural/procedural.h"
#include "tests/datagen/hand_built_scenes.h"
#include "tests/validate/light/lit_scenes.h"

namespace nlg {
namespace {

class LightPlacesTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { lit_ = new LitScene(brightAndDarkRoom()); }
  static void TearDownTestSuite() { delete lit_; }
  static LitScene* lit_;
};
LitScene* LightPlacesTest::lit_ = nullptr;

TEST_F(LightPlacesTest, AreAllInAir) {
  const LightPlaces places = lit_->places();
  EXPECT_EQ(places.in_air, 200u);
  EXPECT_EQ(places.walk_count, 4u);
  for (const LightPlace& place : places.places) {
    const glm::dvec3& at = place.position_m;
    EXPECT_TRUE(isInAir(lit_->rays, at));
    EXPECT_FALSE(at.x > kWallLow && at.x < kWallHigh) << "in the wall: " << at.x;
    EXPECT_NEAR(glm::length(place.normal), 1.0f, 1e-5f);
  }
}

TEST_F(LightPlacesTest, StandBeforeSurfacesAtDistancesOfTheirClass) {
  const LightPlaces places = lit_->places();
  for (const LightPlace& place : places.places) {
    if (place.group != PlaceGroup::surface) continue;
    // back along the normal stands the surface, and nothing before it
    const LightHit hit = lit_->rays.lightHit(glm::vec3(place.position_m), -place.normal);
    ASSERT_EQ(hit.kind, LightHit::Kind::surface);
    EXPECT_GE(hit.distance, kSurfaceBordersM[place.surface_class] - 1e-5);
    EXPECT_LE(hit.distance, kSurfaceBordersM[place.surface_class + 1] + 1e-5);
    EXPECT_GT(glm::dot(hit.normal, place.normal), 0.999f);
  }
  for (const uint64_t count : places.surface_count) EXPECT_EQ(count, 50u);
}

TEST_F(LightPlacesTest, WalksNeverPassAWall) {
  const LightPlaces places = lit_->places();
  size_t steps = 0;
  for (size_t i = 1; i < places.places.size(); ++i) {
    const LightPlace &from = places.places[i - 1], &to = places.places[i];
    if (from.group != PlaceGroup::walk || to.group != PlaceGroup::walk || from.walk != to.walk) continue;
    EXPECT_NEAR(glm::distance(from.position_m, to.position_m), 1.0 / 16.0, 1e-6);
    EXPECT_EQ(from.position_m.x < 0.4, to.position_m.x < 0.4);
    ++steps;
  }
  EXPECT_GE(steps, 4u * 15u);
}

TEST_F(LightPlacesTest, WeighDistancesByTheirShare) {
  const LightPlaces places = lit_->places();
  double surface = 0.0, turned = 0.0;
  for (const LightPlace& place : places.places) {
    if (place.group == PlaceGroup::surface) surface += places.surfaceWeight(place.surface_class);
    if (place.group == PlaceGroup::turned) turned += places.surfaceWeight(place.surface_class);
  }
  EXPECT_NEAR(surface, 1.0, 1e-12);
  EXPECT_NEAR(turned, 1.0, 1e-12);
  EXPECT_EQ(places.surfaceWeight(0), 0.0) << "nearer than 5 cm is a figure of its own";
  EXPECT_NEAR(places.surfaceWeight(3) / places.surfaceWeight(1), 6.0, 1e-9) << "30 cm against 5 cm";
}

// The rooms stand along the axes from y = 0 to 3, z = 0 to 3, with walls at x = kWallLow and kWallHigh.
double fromNextWall(const glm::dvec3& at, int axis) {
  double low = 0.0, high = 3.0;
  if (axis == 0) low = at.x < 0.4 ? kWallLow - 3.0 : kWallHigh, high = low + 3.0;
  return std::min(at[axis] - low, high - at[axis]);
}

TEST_F(LightPlacesTest, OfEdgesStandBeforeOneWallAndBesideOneMoreOfCornersTwoMore) {
  const LightPlaces places = lit_->places();
  EXPECT_EQ(places.edge_count, 400u);
  EXPECT_EQ(places.corner_count, 400u);
  for (const LightPlace& place : places.places) {
    if (place.group != PlaceGroup::edge && place.group != PlaceGroup::corner) continue;
    int beside = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double distance = fromNextWall(place.position_m, axis);
      if (std::fabs(place.normal[axis]) > 0.5f) {
        EXPECT_NEAR(distance, kEdgeOffM, 1e-5);
      } else {
        EXPECT_GT(distance, kEdgeLowM - 1e-5);
        beside += distance < kEdgeHighM + 1e-5;
      }
    }
    EXPECT_GE(beside, place.group == PlaceGroup::corner ? 2 : 1);
  }
}

// Outside there is no roof: what is under one is the room of 5 x 3 x 4 m and the window in its wall to z = 4.2.
TEST(LightPlaces, OfEdgesAreUnderARoofAndNotInTheSun) {
  const Scene scene = makeBuiltInScene("daylight", 0);
  const RayScene rays(scene);
  const glm::vec3 to_sun = scene.light.suns.front().to_sun;
  const LightPlaces places = drawLightPlaces(scene, rays, lightExtent(scene, {}), {});
  EXPECT_EQ(places.edge_count, 400u);
  EXPECT_EQ(places.corner_count, 400u);
  for (const LightPlace& place : places.places) {
    if (place.group != PlaceGroup::edge && place.group != PlaceGroup::corner) continue;
    const glm::vec3 at(place.position_m);
    EXPECT_TRUE(glm::all(glm::greaterThan(at, glm::vec3(0.0f))) && glm::all(glm::lessThan(at, glm::vec3(5.0f, 3.0f, 4.2f))));
    EXPECT_TRUE(glm::dot(to_sun, place.normal) <= 0.0f || rays.isLightBlocked(at, at + 100.0f * to_sun));
  }
}

// A room of 10 x 4 x 10 m with lava over half of its floor, which is no geometry.
TEST(LightPlaces, KeepAwayFromWhatShinesWithoutBeingGeometry) {
  constexpr double kLavaM = 0.4;
  Scene scene = SceneOfFaces().addRoom({0, 0, 0}, {10, 4, 10}, 0.2f).finish();
  SkyFaces& lava = scene.light.sky_faces;
  lava.positions = {{0, kLavaM, 0}, {0, kLavaM, 10}, {5, kLavaM, 10}, {5, kLavaM, 0}};
  lava.triangles = {{0, 1, 2}, {0, 2, 3}};
  lava.shine.assign(2, glm::vec3(1.0f));
  LightPlaceOptions options;
  const LightPlaces places = drawLightPlaces(scene, RayScene(scene), lightExtent(scene, {}), options);
  EXPECT_EQ(places.in_air, options.air);
  EXPECT_GT(places.near_source, 0u);
  for (const LightPlace& place : places.places) {
    if (place.group == PlaceGroup::air && place.position_m.x < 5.0) {
      EXPECT_GE(std::fabs(place.position_m.y - kLavaM), places.source_distance_m - 1e-5);
    }
  }
}

}  // namespace
}  // namespace nlg
