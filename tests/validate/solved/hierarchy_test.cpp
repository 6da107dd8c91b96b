#include "validate/solved/hierarchy.h"

#include <gtest/gtest.h>

#include "tests/runtime_eval/sample_generator.h"
#include "validate/solved/approximation.h"
#include "validate/solved/walk.h"

namespace nlg {
namespace {

const SolvedScene& room() {
  static const SolvedScene scene("doorway", [] {
    SolveSetup setup;
    setup.samples = {8, 4};
    setup.light.rays_per_point = 64;
    setup.light.rays_per_element = 64;
    setup.light.fit_lamps = 4;
    setup.light.test_lamps = 2;
    setup.solve.steps = 2;
    return setup;
  }());
  return scene;
}

BlendWeights bareTents() { return generateWeights(room().table, room().views, room().points, {"", Baseline::bare_tent}); }

const TargetFunctions& targets() {
  static const TargetFunctions functions = targetFunctions(room(), {"present"});
  return functions;
}

void expectBareTents(const Approximation& approximation) {
  const BlendWeights expected = bareTents();
  for (size_t i = 0; i < expected.size(); ++i) {
    for (int c = 0; c < kCornerCount; ++c)
      ASSERT_NEAR(approximation.weights[i][c], expected[i][c], 1e-6f) << "point " << i << ", " << c;
  }
  EXPECT_GT(approximation.function_rmse_mean, 0.01) << "walls cut functions off, tents go on behind them";
}

TEST(Approximation, ByATentIsTheBareTentEverywhere) {
  const Representation representation = Representation::tentMlp();
  Theta one(representation.thetaCount(), 0.0f);
  one.back() = 1.0f;  // the last bias: the network is 1 everywhere
  const size_t count = targets().phi.size();
  ASSERT_GT(count, 0u);
  expectBareTents(approximate(room(), targets(), representation, ThetaOfFunctions(count, one)));
  expectBareTents(approximate(room(), targets(), representation, ThetaOfFunctions(count)));
}

TEST(TargetFunctions, AreWhatShardsWouldHold) {
  // phi is 0 at every invalid point, and no function is empty
  ASSERT_EQ(targets().of_probe.size(), room().views.size());
  for (const StoredFunction& stored : targets().views()) {
    int lit = 0;
    for (int p = 0; p < kSupportPointCount; ++p) {
      const bool is_valid = stored.validity[p / 8] >> (p % 8) & 1;
      EXPECT_TRUE(is_valid || stored.phi[p] == 0) << "point " << p;
      lit += stored.phi[p] > 0;
    }
    EXPECT_GT(lit, 0);
  }
}

TEST(Walk, OfBareTentsChangesByTheTentsSlope) {
  const WalkFigures tents = walk(room(), bareTents());
  EXPECT_GT(tents.step_count, 100u);
  // between eight probes a step along an axis moves 1/16 of the weight from one side to the other
  EXPECT_GE(tents.weight_jump_worst, 1.0 / kSlicePixelsACell - 1e-5);
  EXPECT_LE(tents.weight_jump_p99, tents.weight_jump_worst);
  EXPECT_LE(tents.weight_jump_worst, 1.0);
}

TEST(Walk, UnderTheLightingItselfTakesTheSameSteps) {
  const WalkFigures truth = walkTrueLight(room());
  EXPECT_EQ(truth.step_count, walk(room(), bareTents()).step_count);
  EXPECT_GT(truth.light_jump_worst, 0.0);
  EXPECT_EQ(truth.weight_jump_worst, 0.0);
}

TEST(Hierarchy, AddsEveryStepToTheOneThatItRestsOn) {
  std::vector<Generator> generators;
  GeneratorData data = sampleGenerator(Representation::tentMlp(), 24, 3, 1);
  data.correction.exact_last_layer = true;
  generators.emplace_back(std::move(data));
  DirectOptions direct;
  direct.adam_steps = 300, direct.levenberg_iterations = 1, direct.restarts = 1;
  PolicyOptions policy;
  policy.stages.adam_steps = 50;
  policy.refinement.rounds = 1, policy.refinement.first_steps = 50;
  policy.theta_precision = ThetaPrecision::int8;
  const nlohmann::ordered_json json = hierarchyJson(room(), generators, policy, direct);
  const auto& steps = json["hierarchy"];
  const char* names[] = {"solved", "target", "best known", "network", "corrected", "fitted", "stored"};
  const size_t rests_on[] = {0, 0, 1, 2, 2, 2, 2};
  ASSERT_EQ(steps.size(), std::size(names));
  for (size_t i = 0; i < steps.size(); ++i) {
    EXPECT_EQ(steps[i]["step"], names[i]);
    EXPECT_EQ(steps[i]["scene"], "doorway");
    EXPECT_EQ(steps[i]["representation"].is_null(), i < 2);
    EXPECT_GT(steps[i]["rmse_mean"].get<double>(), 0.0);
    if (i == 0) continue;
    EXPECT_DOUBLE_EQ(steps[i]["rmse_added"].get<double>(),
                     steps[i]["rmse_mean"].get<double>() - steps[rests_on[i]]["rmse_mean"].get<double>());
  }
  EXPECT_TRUE(steps[0]["rmse_added"].is_null());
  const auto functionRmse = [&](size_t step) { return steps[step]["function_rmse"].get<double>(); };
  EXPECT_LT(functionRmse(4), functionRmse(3)) << "a generator of random numbers is easily corrected";
  EXPECT_LT(functionRmse(2), functionRmse(5)) << "fits from what is fitted are among the best known ones";
  EXPECT_NE(functionRmse(5), functionRmse(6)) << "what is stored is rounded";
  EXPECT_EQ(json["walks"].size(), 9u) << "seven steps, bare tents, and the lighting itself";
}

}  // namespace
}  // namespace nlg
