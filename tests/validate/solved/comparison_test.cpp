#include "validate/solved/comparison.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace nlg {
namespace {

SolveSetup smallSetup() {
  SolveSetup setup;
  setup.samples = {16, 8};
  setup.light.rays_per_point = 128;
  setup.light.rays_per_element = 128;
  setup.light.fit_lamps = 8;
  setup.light.test_lamps = 4;
  setup.solve.steps = 5;
  return setup;
}

const SolvedScene& doorway() {
  static const SolvedScene scene("doorway", smallSetup());
  return scene;
}

TEST(DiffusionRule, OfTheBuildersOptionsIsWhatTheBuilderBuilds) {
  const SolvedScene& scene = doorway();
  GeneratedFunction function;
  for (const DiffusionOptions& options : {DiffusionOptions{}, DiffusionOptions{3, 0.2, 1.0}}) {
    WeightingBuilder builder(scene.rays, scene.table, options);
    const DiffusionRule rule{"", Baseline::none, Carry::weight, options.passes, options.sigma, options.falloff};
    for (size_t probe = 0; probe < scene.views.size(); probe += 5) {
      const std::vector<float> phi = generate(scene.table, scene.views[probe], rule);
      if (builder.build(scene.points.probe_position_m[probe], 1.0f, &function) == ProbeOutcome::free_space) continue;
      // Gaussians are floats in one and doubles in the other; a value is an average of values up to 1, pass after pass
      for (size_t p = 0; p < phi.size(); ++p) {
        ASSERT_NEAR(phi[p], function.valid[p] ? function.phi[p] : 0.0f, 12 * options.passes * 0x1p-24) << "point " << p;
      }
    }
  }
}

TEST(DiffusionRule, LeavesSeenPointsTheTentUnderEveryCarry) {
  const SolvedScene& scene = doorway();
  for (const Carry carry : {Carry::weight, Carry::share, Carry::path}) {
    const DiffusionRule rule{"", Baseline::none, carry, 3, 0.1, 2.0, 2.0};
    for (size_t probe = 0; probe < scene.views.size(); probe += 7) {
      const ProbeView& view = scene.views[probe];
      if (view.free_space) continue;
      const std::vector<float> phi = generate(scene.table, view, rule);
      for (size_t p = 0; p < phi.size(); ++p) {
        if (view.seen[p]) {
          ASSERT_EQ(phi[p], tent(scene.table.points[p])) << "point " << p;
        }
        ASSERT_TRUE(phi[p] >= 0.0f && phi[p] <= 1.0f) << "point " << p << ": " << phi[p];
        if (carry != Carry::weight) {
          ASSERT_LE(phi[p], tent(scene.table.points[p])) << "point " << p;
        }
      }
    }
  }
}

TEST(LightField, IsOneOnAverageAndTheSameAgain) {
  const SolvedScene& scene = doorway();
  const LightField again = gatherLight(scene.rays, scene.scene, scene.points, smallSetup().light);
  EXPECT_EQ(again.fit.value, scene.light.fit.value);
  EXPECT_EQ(again.test.value, scene.light.test.value);
  ASSERT_EQ(again.fit.count, 8 * kAxisCount);
  for (int lamp = 0; lamp < 8; ++lamp) {
    double sum = 0.0;
    for (size_t i = 0; i < scene.points.count(); ++i) {
      for (int axis = 0; axis < kAxisCount; ++axis) sum += std::pow(again.fit.row(i)[lamp * kAxisCount + axis], 2.0);
    }
    EXPECT_NEAR(sum / static_cast<double>(scene.points.count() * kAxisCount), 1.0, 1e-3) << "lamp " << lamp;
  }
}

TEST(LightField, StopsAtAWall) {
  SolveSetup setup = smallSetup();
  const SmallScene small = makeSmallScene("two_rooms");
  const Scene scene = small.makeScene();
  const RayScene rays(scene);
  const SamplePoints points = makeSamplePoints(small, setup.samples);
  const LightField light = gatherLight(rays, scene, points, setup.light);
  for (int lamp = 0; lamp < 8; ++lamp) {
    double left = 0.0, right = 0.0;
    for (size_t i = 0; i < points.count(); ++i) {
      for (int axis = 0; axis < kAxisCount; ++axis) {
        (points.position_m[i].x < 2.5f ? left : right) += light.fit.row(i)[lamp * kAxisCount + axis];
      }
    }
    EXPECT_EQ(std::min(left, right), 0.0) << "lamp " << lamp;
    EXPECT_GT(std::max(left, right), 0.0) << "lamp " << lamp;
  }
}

TEST(Comparison, SeesTheTentLeakAndTheSeenTentNot) {
  const SolvedScene scene("two_rooms", smallSetup());
  const auto quality = [&](Baseline baseline) {
    return judge(scene, generateWeights(scene.table, scene.views, scene.points, {"", baseline}));
  };
  const Quality tent = quality(Baseline::bare_tent), seen = quality(Baseline::visible_tent);
  EXPECT_GT(tent.leak, 0.1);
  EXPECT_EQ(seen.leak, 0.0);
  EXPECT_GT(tent.rmse_occluded, 1.1 * seen.rmse_occluded);
  EXPECT_LT(judge(scene, scene.solved.weights).distance_solved, 1e-6);  // weights are normalised once more
}

TEST(SmallScene, KeepsProbesAndPointsOutOfSolids) {
  for (const std::string& name : smallSceneNames()) {
    const SmallScene small = makeSmallScene(name);
    const SamplePoints points = makeSamplePoints(small, {8, 4});
    ASSERT_GE(points.probe_position_m.size(), 24u) << name;
    ASSERT_GE(points.count(), 100u) << name;
    for (const glm::vec3& at : points.probe_position_m) ASSERT_TRUE(small.inAir(at)) << name;
    for (const glm::vec3& at : points.position_m) ASSERT_TRUE(small.inAir(at)) << name;
    for (size_t i = 0; i < points.count(); ++i) {
      for (const int probe : points.probe[i]) {
        if (probe < 0) continue;
        const glm::vec3 away = glm::abs(points.position_m[i] - points.probe_position_m[probe]);
        ASSERT_LE(std::max({away.x, away.y, away.z}), 1.0f + 1e-5f) << name << ": a point outside its probe's support";
      }
    }
  }
}

}  // namespace
}  // namespace nlg
