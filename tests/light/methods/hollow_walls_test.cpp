// Walls of two sheets beside the same walls as solid: light must not tell them apart.
#include <gtest/gtest.h>

#include "light/methods/weightings.h"
#include "light/probe_light.h"
#include "nlg/look_up.h"
#include "tests/scene/windowed_room.h"
#include "tests/validate/light/lit_scenes.h"

namespace nlg {
namespace {

Scene daylitRoom(bool is_hollow, double cavity_m) {
  Scene scene = windowedRoom(is_hollow);
  scene.cavity_m = cavity_m;
  scene.light.sky = {glm::vec3(1.0f), glm::vec3(1.0f), glm::vec3(0.3f)};
  return scene;
}

// Light of the room's probes by target functions, and what they give before the wall around the window.
struct SolvedRoom {
  explicit SolvedRoom(Scene made) : lit(std::move(made)), tree(treeOfAir(lit.tree, lit.air)) {
    const std::vector<LightSh> light = measureLight(lit.transport, lit.air.places, {64, 8}, 1, 1);
    probes = lightProbes(lit.transport, tree, lit.air.places, light, weights(lit.air.places), {}, 1).light;
  }

  WeightsAt weights(const std::vector<glm::dvec3>& places) const {
    const auto all = std::make_shared<std::vector<TrueWeights>>(trueWeights(places, tree, lit.rays, {}, 1));
    return [&places, all](const glm::dvec3& place, ProbeWeights* weights) {
      const size_t at = std::find(places.begin(), places.end(), place) - places.begin();
      weights->count = 0;
      for (int c = 0; c < kCornerCount; ++c) {
        if (!((*all)[at].target[c] > 0.0f)) continue;
        weights->probe[weights->count] = (*all)[at].probe[c];
        weights->weight[weights->count++] = (*all)[at].target[c];
      }
    };
  }

  // Of radiance over all directions, at a place.
  double meanAt(const glm::dvec3& place) const {
    const std::vector<glm::dvec3> places{place};
    ProbeWeights blend;
    weights(places)(place, &blend);
    double sum = 0.0, light = 0.0;
    for (int i = 0; i < blend.count; ++i) {
      sum += blend.weight[i];
      light += blend.weight[i] * 0.28209479 * probes[blend.probe[i]][0].g;
    }
    return sum > 0.0 ? light / sum : 0.0;
  }

  LitScene lit;
  ProbeTree tree;
  std::vector<LightSh> probes;
};

TEST(HollowWalls, HaveTheAirAndTheLightOfSolidOnes) {
  const SolvedRoom solid(daylitRoom(false, 0.5)), hollow(daylitRoom(true, 0.5)), without_rule(daylitRoom(true, 0.0));
  EXPECT_EQ(hollow.lit.air.places, solid.lit.air.places);
  EXPECT_GT(hollow.lit.air.in_cavities, 0u);
  EXPECT_EQ(solid.lit.air.in_cavities, 0u);
  double worst = 0.0, worst_without = 0.0;
  for (const double x : {-1.7, -1.2, -0.8, 0.8, 1.2, 1.7}) {
    for (const double y : {0.3, 1.2, 2.2}) {
      const glm::dvec3 before_wall(x, y, kRoomHigh.z - 0.03);
      const double wanted = solid.meanAt(before_wall);
      worst = std::max(worst, std::fabs(hollow.meanAt(before_wall) / wanted - 1.0));
      worst_without = std::max(worst_without, std::fabs(without_rule.meanAt(before_wall) / wanted - 1.0));
    }
  }
  // the same functions of the same places: only rays that graze a sheet's edge may go another way
  EXPECT_LT(worst, 0.01);
  EXPECT_GT(worst_without, 0.1) << "this room does not need the rule";
}

}  // namespace
}  // namespace nlg
