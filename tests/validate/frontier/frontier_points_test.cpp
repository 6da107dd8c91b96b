#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/policy/stage_plan.h"
#include "runtime_eval/policy/stage_runner.h"
#include "tests/runtime_eval/sample_dictionary.h"
#include "tests/runtime_eval/sample_generator.h"
#include "tool/error.h"
#include "validate/frontier/frontier_json.h"
#include "validate/frontier/timed_policy.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kFunctionCount = 6, kTest = 8;

// Tents that walls cut off at several depths, in two scenes.
const FunctionSet& sampleSet() {
  static const FunctionSet set = [] {
    FunctionSet made;
    made.point_count = kSupportPointCount;
    made.test_point_count = kTest;
    made.scene_ids = {"hall", "cellar"};
    for (int i = 0; i < kFunctionCount; ++i) {
      made.scene_idx.push_back(static_cast<uint32_t>(i % 2));
      for (const LocalPoint& point : supportPattern().points) {
        const bool is_lit = point[0] < 0.1f * static_cast<float>(i + 1);
        made.phi.push_back(is_lit ? static_cast<uint8_t>(std::lround(255.0f * tent(point))) : 0);
      }
    }
    made.validity.assign(kFunctionCount * kValidityByteCount, 0xff);
    made.seen = made.validity;
    made.phi_test.assign(kFunctionCount * kTest, 0);
    made.validity_test.assign(kFunctionCount * kTest / 8, 0xff);
    made.seen_test = made.validity_test;
    return made;
  }();
  return set;
}

std::vector<FunctionBlock> sampleBlocks() {
  return {makeBlocks(sampleSet(), {0, 1, 2, 3}).front(), makeBlocks(sampleSet(), {4, 5}).front()};
}

// All of them take a theta, every second one is hard.
const ChosenFunctions& sampleFunctions() {
  static const ChosenFunctions functions = {{0, 1, 2, 3, 4, 5}, {false, true, false, true, true, false}};
  return functions;
}

std::vector<PointMeasurement> measure(const std::vector<PlotRun>& runs, const InterleaveOptions& options) {
  return measureInterleaved(sampleSet(), sampleFunctions(), sampleBlocks(), runs, PolicyOptions().check(), options,
                            [](int64_t) {});
}

std::vector<PointMeasurement> measureOnce(const std::vector<PlotRun>& runs) { return measure(runs, {0, 0.0}); }

TEST(PointFigures, AreMeansOfRunsAndQuantilesOverThem) {
  PointMeasurement measured;
  measured.rmse = {1, 2, 3, 4, 5, 6};
  measured.blend_rmse = {20, 20, 30, 40, 50, 60};
  measured.fails_check = {true, false, false, true, true, false};
  measured.took_fit = {true, true, false, false, false, false};
  measured.times = {{0, {1, 2, 3, 4}}, {1, {10, 20}}, {0, {3, 2, 1, 4}}};
  const Json figures = pointFigures(measured, sampleSet(), sampleFunctions(), sampleBlocks());
  const auto expectThose = [](const Json& of, const Json& expected) {
    for (const auto& [key, value] : expected.items()) EXPECT_EQ(of.at(key), value) << key;
  };
  expectThose(figures["figures"]["theta"], {{"us_median", 2.5},
                                            {"us_p25", 2.5},
                                            {"us_p75", 0.5 * (2.5 + 15)},
                                            {"rmse_mean", 3.5},
                                            {"blend_rmse_median", 35.0},
                                            {"blend_rmse_worst", 60.0},
                                            {"share_fitted", 2.0 / 6.0},
                                            {"share_failing_check", 3.0 / 6.0}});
  // hard: functions 1, 3 and 4, with times 3, 10 and 3
  expectThose(figures["figures"]["hard"], {{"rmse_mean", 11.0 / 3.0},
                                           {"blend_rmse_median", 40.0},
                                           {"us_median", 3.0},
                                           {"blend_rmse_mean", 110.0 / 3.0},
                                           {"share_fitted", 1.0 / 3.0},
                                           {"share_failing_check", 2.0 / 3.0}});
  // walls cut off less and less: of two scenes in turn the first has the larger errors
  const Json tent = tentFigures(sampleSet(), sampleFunctions(), PolicyOptions().check().loss());
  const auto errorOf = [](const Json& of) { return of.at("blend_rmse_mean").get<double>(); };
  const double hall = errorOf(tent["by_scene"]["hall"]), cellar = errorOf(tent["by_scene"]["cellar"]);
  EXPECT_GT(hall, cellar);
  EXPECT_NEAR(errorOf(tent["figures"]["theta"]), 0.5 * (hall + cellar), 1e-12);
  // functions 0, 2 and 4 are the hall's: times 2, 10 and 2
  expectThose(figures["by_scene"]["hall"], {{"us_median", 2.0}, {"blend_rmse_median", 30.0}});
  expectThose(figures["by_scene"]["cellar"], {{"rmse_mean", 4.0}, {"blend_rmse_mean", 40.0}});
  EXPECT_EQ(functionTimes(measured, sampleBlocks()), (std::vector<double>{2, 2, 2, 4, 10, 20}));
}

TEST(ChosenFunctions, AreThoseThatTakeATheta) {
  FunctionSet set;
  set.point_count = kSupportPointCount;
  set.scene_ids = {"hall", "cellar"};
  const auto add = [&](uint32_t scene, bool is_tent) {
    set.scene_idx.push_back(scene);
    for (const LocalPoint& point : supportPattern().points) {
      set.phi.push_back(is_tent || point[0] < 0 ? static_cast<uint8_t>(std::lround(255.0f * tent(point))) : 0);
    }
    set.validity.insert(set.validity.end(), kValidityByteCount, 0xff);
  };
  // a third of the hall takes a theta, a half of the cellar
  for (int i = 0; i < 6; ++i) add(0, i % 3 != 0);
  for (int i = 0; i < 4; ++i) add(1, i % 2 != 0);
  set.seen = set.validity;
  const PolicyOptions policy;
  const ChosenFunctions all = chooseFunctions(set, 100, policy, 0.01);
  EXPECT_EQ(std::set<uint64_t>(all.with_theta.begin(), all.with_theta.end()), (std::set<uint64_t>{0, 3, 6, 8}));
  EXPECT_EQ(all.hard, std::vector<bool>(4, true)) << "half a tent is far from the tent";
  const ChosenFunctions some = chooseFunctions(set, 2, policy, 10.0);
  EXPECT_EQ(some.with_theta.size(), 2u);
  EXPECT_EQ(some.hard, std::vector<bool>(2, false));
  PolicyOptions every;
  every.bare_tent_rmse = 0.0;
  EXPECT_EQ(chooseFunctions(set, 100, every, 0.01).with_theta.size(), 10u);
  PolicyOptions none;
  none.bare_tent_rmse = 1e3, none.tau_rmse = 1.0, none.tau_blend = 1e3, none.tau_leak = 1.0;
  EXPECT_THROW(chooseFunctions(set, 100, none, 0.01), InputError);
}

GeneratorData sampleData(const Representation& representation) {
  GeneratorData data = sampleGenerator(representation, 24, 3, 7);
  data.exact_last_layer = !representation.isField() && representation.shape().output == OutputFunction::linear;
  return data;
}

std::shared_ptr<const Generator> sampleShared(const Representation& representation) {
  return std::make_shared<const Generator>(sampleData(representation));
}

std::vector<Theta> thetaOf(const std::vector<FittedFunction>& functions) {
  std::vector<Theta> thetas;
  for (const FittedFunction& function : functions) {
    EXPECT_GT(function.elapsed_us, 0.0);
    thetas.push_back(function.theta);
  }
  return thetas;
}

// What the first point of a family and budget makes; of `stages`, the one of that label.
std::vector<FittedFunction> runPoint(const std::vector<PlotRun>& runs, const FunctionBlock& block, const std::string& family,
                                     std::optional<int> budget = {}, const std::string& label = "") {
  for (const PlotRun& run : runs) {
    for (size_t p = 0; p < run.points.size(); ++p) {
      const PlotPoint& point = run.points[p];
      if (point.family == family && point.budget == budget && (label.empty() || point.label == label)) return run.run(block)[p];
    }
  }
  throw std::runtime_error("no point of family " + family + ' ' + label);
}

std::vector<PlotPoint> pointsOf(const std::vector<PlotRun>& runs) {
  std::vector<PlotPoint> points;
  for (const PlotRun& run : runs) points.insert(points.end(), run.points.begin(), run.points.end());
  return points;
}

TEST(FitPoints, StartWhereTheySayAndNeverEndAboveIt) {
  const auto generator = sampleShared(Representation::tentMlp());
  const FitBudgets budgets = {{1, 4}, {16}, {8}, {64}};
  const auto corrected = std::make_shared<TimedPolicy>(generator, PolicyOptions{}, ThetaStage::last_layer);
  std::vector<PlotRun> runs = {{{{"tent_mlp", "stages", {}, "corrected", {}}},
                                [&](const FunctionBlock& block) { return FittedFunctions{corrected->run(block)}; }}};
  for (PlotRun& run : fitsOfCorrected(generator, {}, budgets)) runs.push_back(std::move(run));
  const std::vector<PlotPoint> points = pointsOf(runs);
  const std::vector<PointMeasurement> measured = measureOnce(runs);
  ASSERT_EQ(measured.size(), 4u);
  for (size_t p = 1; p < points.size(); ++p) {
    EXPECT_FALSE(points[p].is_direct);
    for (int i = 0; i < kFunctionCount; ++i) {
      // fits read the kernels' sums, errors the evaluator's: the two differ by rounding
      EXPECT_LE(measured[p].blend_rmse[i], measured[0].blend_rmse[i] * (1 + 1e-5)) << points[p].label << ", " << i;
      EXPECT_TRUE(measured[p].took_fit[i]);
    }
  }
  const std::vector<PlotRun> direct = directFits(generator, {}, budgets, 3);
  std::set<std::string> families;
  for (const PlotPoint& point : pointsOf(direct)) {
    families.insert(point.family);
    EXPECT_TRUE(point.is_direct);
  }
  std::set<std::string> expected;
  for (const char* family : {"lm_from_theta0", "adam_from_theta0", "adam_from_random"}) {
    for (const char* gate : {"", "_gated"}) expected.insert(family + std::string(gate));
  }
  EXPECT_EQ(families, expected);
  const FunctionBlock block = makeBlocks(sampleSet(), {0, 1}).front();
  const auto random = [&] { return thetaOf(runPoint(direct, block, "adam_from_random", 64)); };
  EXPECT_EQ(random(), random()) << "the same start every time";
}

}  // namespace
}  // namespace nlg
