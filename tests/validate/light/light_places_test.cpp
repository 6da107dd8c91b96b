#include "validate/light/light_places.h"

#include <gtest/gtest.h>

#include "light/air.h"
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

TEST_F(LightPlacesTest, AreTheSameForTheSameSeed) {
  const LightPlaces one = lit_->places(), other = lit_->places();
  ASSERT_EQ(one.places.size(), other.places.size());
  for (size_t i = 0; i < one.places.size(); ++i) {
    EXPECT_EQ(one.places[i].position_m, other.places[i].position_m);
    EXPECT_EQ(one.places[i].normal, other.places[i].normal);
  }
}

}  // namespace
}  // namespace nlg
