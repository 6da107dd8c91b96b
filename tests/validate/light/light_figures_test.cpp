#include "validate/light/light_figures.h"

#include <gtest/gtest.h>

#include <map>

#include "tests/validate/light/lit_scenes.h"

namespace nlg {
namespace {

using FiguresByMethod = std::map<std::string, LightFigures>;

FiguresByMethod measureAll(const LitScene& lit) {
  LightPlaces places = lit.places();
  partIntoRooms(&places, lit.rays, 1);
  const LightTruth truth = lightTruth(places, lit.transport, {{256, 64}});
  MethodSet methods = lit.methods();
  for (const MethodSet::Baseline& baseline : MethodSet::baselines()) (methods.*baseline.add)(MethodSet::kGatheredAndSolved);
  std::vector<glm::dvec3> asked;
  for (const LightPlace& place : places.places) asked.push_back(place.position_m);
  methods.addTargetFunctions(asked, {});
  FiguresByMethod figures;
  for (const LightMethod& method : methods.methods())
    figures[method.weights + ", " + method.light] =
        lightFigures(places, truth, answersAt(method.light_at, receiversAt(places), 1));
  return figures;
}

// Everything shines alike, so that all blends of all probes are right. What is left: 64 and 256 directions add up second-order
// harmonics to within a percent or two, DDGI's texels cosines.
TEST(LightFigures, AreZeroInAFurnace) {
  const LitScene lit(furnace());
  for (const auto& [name, f] : measureAll(lit)) {
    EXPECT_LT(f.air.rmse, 0.02) << name;
    EXPECT_LT(f.surface.rmse, 0.02) << name;
    EXPECT_LT(f.turned.rmse, 0.02) << name;
    EXPECT_LT(f.air.smape, 0.02) << name;
    EXPECT_LT(f.jumps.largest, 0.02) << name;
    EXPECT_EQ(f.dark.places, 0u) << name;
    EXPECT_LT(f.air.balanced, 0.02) << name;
    EXPECT_NEAR(f.air.energy, 1.0, 0.02) << name;
    EXPECT_NEAR(f.edge.excess, 0.0, 0.02) << name;
    EXPECT_NEAR(f.corner.excess, 0.0, 0.02) << name;
    EXPECT_EQ(f.air.unlit, 0.0) << name;
    EXPECT_EQ(f.air.outside, 0.0) << name;
    EXPECT_EQ(f.worst.size(), kWorstPlaceCount) << name;
  }
}

TEST(LightFigures, FindTheLightThatTrilinearBlendsLeak) {
  const LitScene lit(brightAndDarkRoom());
  const FiguresByMethod figures = measureAll(lit);
  const LightFigures &trilinear = figures.at("valid trilinear, point"), &exact = figures.at("exact visibility, point");
  EXPECT_GT(trilinear.dark.places, 50u);
  // of a dark room 3 m long the first .6 m lie in cells with the bright room's probes: a sixth of the light at the least, there
  EXPECT_GT(trilinear.dark.excess, 0.03);
  EXPECT_EQ(exact.dark.excess, 0.0);
  EXPECT_EQ(trilinear.air.rooms, 2u);
  EXPECT_EQ(figures.at("target functions, point").dark.excess, 0.0);
  EXPECT_LT(figures.at("DDGI as shipped, own").dark.excess, trilinear.dark.excess);
  EXPECT_GT(trilinear.air.rmse, exact.air.rmse);
}

TEST(LightFigures, KnowOfNothingBetterThanHarmonicsAtThePlace) {
  const LitScene lit(brightAndDarkRoom());
  const LightPlaces places = lit.places();
  const LightTruth truth = lightTruth(places, lit.transport, {{256, 64}});
  std::vector<LightAnswer> answers;
  for (const LightPlace& place : places.places)
    answers.push_back({irradiance(lit.transport.gather(place.position_m, {256, 64}, 2).light, place.normal), Reach::lit});
  const double floor = lightFigures(places, truth, answers).air.rmse;
  for (const auto& [name, f] : measureAll(lit)) EXPECT_GT(f.air.rmse, floor) << name;
}

// Two rooms with eight places each, which are off by a tenth and by the whole of what light there is, and one with too few to count.
TEST(LightFigures, CountRoomsAlikeByTheLightThatStandsInThem) {
  LightPlaces places;
  LightTruth truth;
  std::vector<LightAnswer> answers;
  places.room_count = 3;
  const auto add = [&](uint32_t room, float light, float answer) {
    places.places.push_back({});
    places.places.back().room = room;
    truth.at.push_back({glm::vec3(light), {}});
    answers.push_back({glm::vec3(answer), Reach::lit});
  };
  for (int i = 0; i < 8; ++i) {
    add(0, 10.0f, 9.0f);
    // the mean of this room is 1: the light that stands at a place is that, or its own where it is more
    add(1, i % 2 ? 0.5f : 1.5f, i % 2 ? 1.5f : 3.0f);
  }
  add(2, 1.0f, 100.0f);
  add(3, 1.0f, 100.0f);  // in no room
  truth.mean = 5.0;
  truth.rms = 7.0;
  const LightFigures f = lightFigures(places, truth, answers);
  EXPECT_EQ(f.air.rooms, 2u);
  EXPECT_NEAR(f.air.balanced, (0.1 + 1.0) / 2, 1e-6);
  EXPECT_NEAR(f.air.energy, (8 * 9.0 + 8 * 2.25 + 200.0) / (8 * 10.0 + 8 * 1.0 + 2.0), 1e-6);
}

TEST(LightFigures, OfEdgesPoolOverPlaces) {
  LightPlaces places;
  LightTruth truth;
  std::vector<LightAnswer> answers;
  places.places.resize(3);
  for (LightPlace& place : places.places) place.group = PlaceGroup::edge;
  truth.mean = 10.0;
  truth.rms = 10.0;
  truth.at = {{glm::vec3(1.0f), {}}, {glm::vec3(4.0f), {}}, {glm::vec3(0.0f), {}}};
  for (const float light : {3.0f, 2.0f, 0.1f}) answers.push_back({glm::vec3(light), Reach::lit});
  const LightFigures f = lightFigures(places, truth, answers);
  EXPECT_EQ(f.edge.places, 3u);
  EXPECT_EQ(f.corner.places, 0u);
  EXPECT_NEAR(f.edge.excess, (5.1 - 5.0) / 5.0, 1e-6);
  EXPECT_EQ(f.dark.places, 0u) << "edges are figures of their own";
  EXPECT_TRUE(f.worst.empty());
}

TEST(LightFigures, CountOnlyJumpsThatTruthDoesNotMake) {
  LightPlaces places;
  LightTruth truth;
  for (uint32_t i = 0; i < 6; ++i) {
    LightPlace step;
    step.group = PlaceGroup::walk;
    step.walk = i / 3;
    places.places.push_back(step);
  }
  for (const float light : {1.0f, 2.0f, 2.0f, 9.0f, 9.0f, 9.0f}) truth.at.push_back({glm::vec3(light), {}});
  truth.rms = 2.0;
  std::vector<LightAnswer> answers;
  for (const float light : {1.0f, 1.5f, 2.0f, 5.0f, 5.0f, 6.0f}) answers.push_back({glm::vec3(light), Reach::lit});
  // changes .5 where truth's is 1, .5 where it is 0, 0, 1 where it is 0; none between the two walks
  const WalkFigures jumps = lightFigures(places, truth, answers).jumps;
  EXPECT_EQ(jumps.steps, 4u);
  EXPECT_NEAR(jumps.largest, 1.0 / 2.0, 1e-6);
  EXPECT_NEAR(jumps.mean, (0.5 + 1.0) / 4 / 2.0, 1e-6);
}

}  // namespace
}  // namespace nlg
