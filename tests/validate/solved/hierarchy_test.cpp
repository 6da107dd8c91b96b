#include "validate/solved/hierarchy.h"

#include <gtest/gtest.h>

#include "tests/runtime_eval/sample_generator.h"
#include "tool/error.h"
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

Weights bareTents() { return generateWeights(room().table, room().views, room().points, {"", Baseline::bare_tent}); }

TEST(Approximation, ByATentIsTheBareTentEverywhere) {
  const Representation representation = Representation::tentMlp();
  Theta one(representation.thetaCount(), 0.0f);
  one.back() = 1.0f;  // the last bias: the network is 1 everywhere
  int asked = 0;
  const Approximation tents =
      approximate(room(), {"present"}, representation, [&](const StoredFunction&) { return ++asked, one; });
  const Weights expected = bareTents();
  for (size_t i = 0; i < expected.size(); ++i) {
    for (int c = 0; c < kCornerCount; ++c) ASSERT_NEAR(tents.weights[i][c], expected[i][c], 1e-6f) << "point " << i << ", " << c;
  }
  EXPECT_GT(asked, 0);
  EXPECT_GT(tents.function_rmse_mean, 0.01) << "walls cut functions off, tents go on behind them";
}

TEST(Approximation, GivesFitsTheFunctionThatShardsWouldHold) {
  // a fit that looks: phi is 0 at every invalid point, and no function is empty
  const Representation representation = Representation::tentMlp();
  approximate(room(), {"present"}, representation, [&](const StoredFunction& stored) {
    int lit = 0;
    for (int p = 0; p < kSupportPointCount; ++p) {
      const bool is_valid = stored.validity[p / 8] >> (p % 8) & 1;
      EXPECT_TRUE(is_valid || stored.phi[p] == 0) << "point " << p;
      lit += stored.phi[p] > 0;
    }
    EXPECT_GT(lit, 0);
    return Theta(representation.thetaCount(), 0.0f);
  });
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

TEST(Hierarchy, ChainsEveryStepToTheOneBefore) {
  std::vector<Generator> generators;
  generators.emplace_back(sampleGenerator(Representation::tentMlp(), 24, 3, 1));
  DirectOptions direct;
  direct.adam_steps = 300, direct.levenberg_iterations = 1, direct.restarts = 1;
  const nlohmann::ordered_json json = hierarchyJson(room(), generators, direct);
  const auto& steps = json["hierarchy"];
  ASSERT_EQ(steps.size(), 4u);
  const char* names[] = {"solved", "generated", "direct fit", "generator"};
  for (size_t i = 0; i < steps.size(); ++i) {
    EXPECT_EQ(steps[i]["step"], names[i]);
    EXPECT_EQ(steps[i]["scene"], "doorway");
    EXPECT_EQ(steps[i]["representation"].is_null(), i < 2);
    EXPECT_GT(steps[i]["rmse_mean"].get<double>(), 0.0);
    if (i == 0) continue;
    EXPECT_DOUBLE_EQ(steps[i]["rmse_added"].get<double>(),
                     steps[i]["rmse_mean"].get<double>() - steps[i - 1]["rmse_mean"].get<double>());
  }
  EXPECT_TRUE(steps[0]["rmse_added"].is_null());
  EXPECT_LT(steps[2]["function_rmse"].get<double>(), steps[3]["function_rmse"].get<double>()) << "a generator of random numbers";
  EXPECT_EQ(json["walks"].size(), 6u) << "four steps, bare tents, and the lighting itself";
}

TEST(Hierarchy, RefusesWhatIsNoGenerator) { EXPECT_THROW(loadGenerators({"no_such_file.safetensors"}), InputError); }

}  // namespace
}  // namespace nlg
