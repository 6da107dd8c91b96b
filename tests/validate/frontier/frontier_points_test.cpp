#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/policy/stage_plan.h"
#include "runtime_eval/policy/stage_runner.h"
#include "tests/runtime_eval/sample_dictionary.h"
#include "tests/runtime_eval/sample_generator.h"
#include "tool/error.h"
#include "validate/frontier/frontier_json.h"
#include "validate/frontier/frontier_options.h"
#include "validate/frontier/timed_policy.h"

namespace nlg {
namespace {

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
  static const ChosenFunctions functions = {{0, 1, 2, 3, 4, 5}, {false, true, false, true, true, false}, {}};
  return functions;
}

BareTents sampleTents() {
  BareTents tents;
  for (const double rmse : {6, 5, 4, 3, 2, 1}) tents.with_theta.push_back({.blend_rmse = 10 * rmse, .rmse = rmse});
  return tents;
}

std::vector<PointMeasurement> measure(const std::vector<PlotRun>& runs, const InterleaveOptions& options) {
  return measureInterleaved(sampleSet(), sampleFunctions(), sampleBlocks(), runs, PolicyOptions().check(), options,
                            [](int64_t) {});
}

std::vector<PointMeasurement> measureOnce(const std::vector<PlotRun>& runs) { return measure(runs, {0, 0.0}); }

// A run that gives a network that is 1 and notes what it was asked for.
struct Asked {
  std::vector<std::vector<uint64_t>> blocks;
  PlotRun run(const std::vector<double>& elapsed_us) {
    PlotRun run;
    for (const double us : elapsed_us) run.points.push_back({"tent_mlp", "stages", {}, std::to_string(us), {}});
    run.run = [this, elapsed_us](const FunctionBlock& block) {
      blocks.push_back(block.functions);
      Theta theta(ThetaLayout::count, 0.0f);
      theta[ThetaLayout::b3] = 1.0f;
      FittedFunctions points;
      for (const double us : elapsed_us) {
        points.emplace_back(block.functions.size(), FittedFunction{Representation::tentMlp(), theta, us});
      }
      return points;
    };
    return run;
  }
};

TEST(Interleaved, RunsEveryPointOnTheSameFunctions) {
  Asked a, b;
  const std::vector<PointMeasurement> measured = measureOnce({a.run({1, 10}), b.run({2})});
  EXPECT_EQ(a.blocks, (std::vector<std::vector<uint64_t>>{{0, 1, 2, 3}, {4, 5}}));
  EXPECT_EQ(a.blocks, b.blocks);
  ASSERT_EQ(measured.size(), 3u) << "a run may give two points";
  EXPECT_EQ(measured[0].times[1].elapsed_us, (std::vector<double>{1, 1}));
  EXPECT_EQ(measured[1].times[1].elapsed_us, (std::vector<double>{10, 10}));
  for (const PointMeasurement& point : measured) {
    ASSERT_EQ(point.rmse.size(), size_t{kFunctionCount});
    ASSERT_EQ(point.blend_rmse.size(), size_t{kFunctionCount});
    for (int i = 1; i < kFunctionCount; ++i) {
      EXPECT_LT(point.rmse[i], point.rmse[i - 1]) << "walls stand further off";
      EXPECT_LT(point.blend_rmse[i], point.blend_rmse[i - 1]);
    }
    EXPECT_GT(point.blend_rmse[0], point.rmse[0]) << "a bare tent leaks through a wall";
    EXPECT_EQ(point.fails_check, std::vector<bool>(kFunctionCount, true));
  }
}

TEST(Interleaved, RepeatsShortRunsAndMakesLongOnesOnce) {
  Asked a;
  // it takes next to nothing: a warming run before every one that counts; the first pass only measures errors
  const auto repeated = measure({a.run({3})}, {4, 1e6});
  EXPECT_EQ(a.blocks.size(), 2u * (1 + 2 * 4));
  EXPECT_EQ(repeated.front().times.size(), 2u * 4);
  Asked b;
  const auto once = measure({b.run({3})}, {4, 0.0});
  EXPECT_EQ(b.blocks.size(), 2u);
  EXPECT_EQ(once.front().times.size(), 2u);
  EXPECT_EQ(once.front().rmse, repeated.front().rmse);
}

TEST(Interleaved, RefusesAnErrorThatIsNotFinite) {
  Asked a;
  PlotRun run = a.run({1});
  run.run = [](const FunctionBlock& block) {
    const FittedFunction broken{Representation::tentMlp(), Theta(ThetaLayout::count, NAN), 1.0};
    return FittedFunctions{std::vector<FittedFunction>(block.functions.size(), broken)};
  };
  EXPECT_THROW(measureOnce({run}), NumericalError);
}

// Of a population.
template <class Figures>
const Figures& of(const ByPopulation<Figures>& figures, Population population) {
  return figures[static_cast<size_t>(population)].value();
}

TEST(PointFigures, AreMeansOfRunsAndQuantilesOverThem) {
  PointMeasurement measured;
  measured.rmse = {1, 2, 3, 4, 5, 6};
  measured.blend_rmse = {20, 20, 30, 40, 50, 60};
  measured.fails_check = {true, false, false, true, true, false};
  measured.took_fit = {true, true, false, false, false, false};
  measured.times = {{0, {1, 2, 3, 4}}, {1, {10, 20}}, {0, {3, 2, 1, 4}}};
  const PointFigures figures = figuresOf(measured, sampleSet(), sampleFunctions(), sampleBlocks(), {});
  const PopulationFigures& theta = of(figures.figures, Population::theta);
  EXPECT_EQ(theta.time.median_us, 2.5);
  EXPECT_EQ(theta.time.p25_us, 2.5);
  EXPECT_EQ(theta.time.p75_us, 0.5 * (2.5 + 15));
  EXPECT_EQ(theta.errors.rmse.median, 3.5);
  EXPECT_EQ(theta.errors.rmse.worst, 6.0);
  EXPECT_EQ(theta.errors.blend_rmse.median, 35.0);
  EXPECT_EQ(theta.share_fitted, 2.0 / 6.0);
  EXPECT_EQ(theta.share_failing_check, 3.0 / 6.0);
  // hard: functions 1, 3 and 4
  const PopulationFigures& hard = of(figures.figures, Population::hard);
  EXPECT_EQ(hard.errors.rmse.median, 4.0);
  EXPECT_EQ(hard.errors.rmse.worst, 5.0);
  EXPECT_EQ(hard.time.median_us, 3.0) << "of 3, 10 and 3";
  EXPECT_EQ(hard.errors.blend_rmse.mean, 110.0 / 3.0);
  EXPECT_EQ(hard.share_fitted, 1.0 / 3.0);
  EXPECT_EQ(hard.share_failing_check, 2.0 / 3.0);
  const TentFigures tent = figuresOfTent(sampleSet(), sampleFunctions(), sampleTents());
  EXPECT_EQ(of(tent.figures, Population::theta).rmse.median, 3.5);
  EXPECT_EQ(of(tent.figures, Population::hard).rmse.mean, 10.0 / 3.0);
  EXPECT_EQ(tent.by_scene.at("hall").rmse.median, 4.0);
  EXPECT_EQ(tent.by_scene.at("hall").blend_rmse.median, 40.0);
  // functions 0, 2 and 4 are the hall's: times 2, 10 and 2
  EXPECT_EQ(figures.by_scene.at("hall").time.median_us, 2.0);
  EXPECT_EQ(figures.by_scene.at("hall").errors.rmse.median, 3.0);
  EXPECT_EQ(figures.by_scene.at("cellar").errors.rmse.mean, 4.0);
  EXPECT_EQ(figures.by_scene.at("cellar").errors.blend_rmse.mean, 40.0);
  EXPECT_EQ(functionTimes(measured, sampleBlocks()), (std::vector<double>{2, 2, 2, 4, 10, 20}));
}

TEST(PointFigures, OfAllFunctionsHoldBareTentsAtTimeZero) {
  PointMeasurement measured;
  measured.rmse = measured.blend_rmse = {1, 2, 3, 4, 5, 6};
  measured.fails_check.assign(6, true);
  measured.took_fit.assign(6, true);
  measured.times = {{0, {8, 8, 8, 8}}};
  const BareTents tents = {{}, {1.5, 1.5}, {0.5, 0.5}, {}};
  const PointFigures figures = figuresOf(measured, sampleSet(), sampleFunctions(), sampleBlocks(), tents);
  const PopulationFigures& all = of(figures.figures, Population::all);
  EXPECT_EQ(all.time.median_us, 6.0) << "two of eight take none";
  EXPECT_EQ(all.errors.rmse.mean, 22.0 / 8.0);
  EXPECT_EQ(all.errors.blend_rmse.mean, 24.0 / 8.0);
  EXPECT_EQ(all.share_failing_check, 0.75) << "a bare tent passes";
  EXPECT_EQ(all.share_fitted, 0.75);
  EXPECT_EQ(of(figures.figures, Population::theta).errors.rmse.mean, 3.5);
}

TEST(ChosenFunctions, TakeBareTentsInTheProportionOfEveryScene) {
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
  EXPECT_EQ(all.count(Population::all), 10u);
  const ChosenFunctions some = chooseFunctions(set, 2, policy, 10.0);
  EXPECT_EQ(some.with_theta.size(), 2u);
  EXPECT_EQ(some.bare_tents.size(), 3u) << "two in the hall, one in the cellar";
  EXPECT_EQ(some.count(Population::hard), 0u);
  PolicyOptions every;
  every.bare_tent_rmse = 0.0;
  EXPECT_EQ(chooseFunctions(set, 100, every, 0.01).count(Population::theta), 10u);
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

TEST(GeneratorPoints, HaveOneAfterEveryStageOfThePolicyAsThePolicyLeavesIt) {
  for (const Representation& representation : {Representation::tentMlp(), Representation::productField(3)}) {
    const std::string name = representationName(representation);
    const auto generator = sampleShared(representation);
    const std::vector<PlotRun> runs = stagePoints(generator, {});
    const FunctionBlock block = makeBlocks(sampleSet(), {0, 1, 2, 3, 4, 5}).front();
    std::map<ThetaWord, Theta> named;
    std::vector<std::string> stages;
    for (const PlotRun& run : runs) {
      if (run.points.front().family != "stages") continue;
      stages.push_back(run.points.front().label);
      const std::vector<FittedFunction> functions = run.run(block).front();
      for (const ThetaWord word : run.points.front().words) {
        EXPECT_TRUE(named.emplace(word, functions.back().theta).second) << name << ": two points are " << wordName(word);
      }
      // functions share out the time of the whole block
      for (const FittedFunction& function : functions) EXPECT_GE(function.elapsed_us, 0.0);
    }
    std::vector<std::string> expected;
    for (const StagePlan& plan : stagesOf(stageFacts(*generator), {})) expected.push_back(stageTitle(plan.stage));
    expected.push_back("rounding to int8");
    EXPECT_EQ(stages, expected) << name;
    ASSERT_EQ(named.size(), size_t{kThetaWordCount}) << name;
    PolicyOptions options;
    options.theta_precision = ThetaPrecision::int8;
    ThetaPolicy policy({generator.get()}, options);
    std::vector<MadeTheta> made(block.functions.size());
    ThetaTrace trace;
    policy.bake(block.stored.data(), block.count(), made.data(), &trace);
    const auto last = [&](const std::vector<float>& all) { return Theta(all.end() - representation.thetaCount(), all.end()); };
    EXPECT_EQ(named[ThetaWord::network], last(trace.network)) << name;
    EXPECT_EQ(named[ThetaWord::corrected], last(trace.corrected)) << name;
    EXPECT_EQ(named[ThetaWord::fitted], last(trace.fitted)) << name;
    EXPECT_EQ(named[ThetaWord::stored], made.back().theta) << name;
  }
}

std::vector<PlotPoint> pointsOf(const std::vector<PlotRun>& runs) {
  std::vector<PlotPoint> points;
  for (const PlotRun& run : runs) points.insert(points.end(), run.points.begin(), run.points.end());
  return points;
}

TEST(FitPoints, StartWhereTheySayAndNeverEndAboveIt) {
  const auto generator = sampleShared(Representation::tentMlp());
  const FitBudgets budgets = {{1, 4}, {16}, {8}, {64}};
  const auto corrected = std::make_shared<TimedPolicy>(SharedGenerators{generator}, PolicyOptions{}, ThetaStage::last_layer);
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

TEST(FitPoints, OfAGateFitOnOnlyWhatIsNotGoodYet) {
  const auto generator = sampleShared(Representation::productField(3));
  const FunctionBlock block = makeBlocks(sampleSet(), {0, 1, 2, 3, 4, 5}).front();
  PolicyOptions lenient;
  lenient.tau_rmse = 1e3, lenient.tau_blend = 1e3;
  const auto gated = [&](double good_rmse, int budget) {
    PolicyOptions options = lenient;
    options.good_rmse = good_rmse;
    return runPoint(directFits(generator, options, {{}, {}, {2, 8, 32}, {}}, 1), block, "lm_from_theta0_gated", budget);
  };
  const Theta theta0(generator->theta0(), generator->theta0() + generator->representation().thetaCount());
  for (const FittedFunction& function : gated(1e3, 32)) {
    EXPECT_EQ(function.theta, theta0) << "everything is good: nothing is fitted";
    EXPECT_FALSE(function.took_fit);
  }
  // what the first round left so good is not touched again, all others are
  const std::vector<FittedFunction> first = gated(0.0, 2), last = gated(0.0, 32);
  std::vector<double> errors;
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_TRUE(first[i].took_fit);
    const PointOrder& order = pointOrder(first[i].representation);
    // what the fits minimise, and what the gate goes by
    const WeightingFunction function = decodeFunction(block.stored[i], order, lenient.check().loss());
    errors.push_back(functionRmse(first[i].representation, function, first[i].theta.data()));
    EXPECT_LE(functionRmse(last[i].representation, function, last[i].theta.data()), errors.back());
  }
  std::vector<double> sorted = errors;
  std::sort(sorted.begin(), sorted.end());
  const double middle = 0.5 * (sorted[2] + sorted[3]);
  const std::vector<FittedFunction> some = gated(middle, 32);
  for (size_t i = 0; i < some.size(); ++i) {
    EXPECT_EQ(some[i].theta == first[i].theta, errors[i] <= middle) << "function " << i;
  }
}

// Of a code Levenberg–Marquardt runs from random starts too: what a start is worth is to be seen.
TEST(FitPoints, OfACodeStartFromItsMeanAndAtRandom) {
  const auto generator = sampleShared(Representation::code(sampleDictionary(5, 16, 1)));
  const std::vector<PlotRun> direct = directFits(generator, {}, {{}, {}, {1, 16}, {320}}, 1);
  std::map<std::string, std::vector<int>> budgets;
  for (const PlotPoint& point : pointsOf(direct)) {
    if (point.family.find("_gated") == std::string::npos) budgets[point.family].push_back(*point.budget);
  }
  const std::map<std::string, std::vector<int>> expected = {
      {"lm_from_theta0", {1, 16}}, {"lm_from_random", {1, 16}}, {"adam_from_theta0", {10}}, {"adam_from_random", {10}}};
  EXPECT_EQ(budgets, expected);
  const FunctionBlock block = makeBlocks(sampleSet(), {0, 1, 2}).front();
  for (const char* family : {"lm_from_theta0", "lm_from_random"}) {
    const std::vector<FittedFunction> first = runPoint(direct, block, family, 1), last = runPoint(direct, block, family, 16);
    for (size_t i = 0; i < first.size(); ++i) {
      const Representation& code = first[i].representation;
      const WeightingFunction function = decodeFunction(block.stored[i], pointOrder(code), CheckOptions().loss());
      EXPECT_LE(functionRmse(code, function, last[i].theta.data()), functionRmse(code, function, first[i].theta.data()))
          << family << ", " << i;
    }
  }
}

TEST(ChoicePoint, IsThePolicyOverSeveralGenerators) {
  SharedGenerators generators;
  std::vector<const Generator*> pointers;
  for (const int r : {3, 5}) {
    generators.push_back(sampleShared(Representation::productField(r)));
    pointers.push_back(generators.back().get());
  }
  const FunctionBlock block = makeBlocks(sampleSet(), {0, 1, 2, 3, 4, 5}).front();
  PolicyOptions options;
  options.choice_flat_ratio = 1.0, options.choice_enough_rmse = 0.0;
  options.theta_precision = ThetaPrecision::float32;  // the plot is of fits
  const PlotRun run = choicePoint(generators, options);
  EXPECT_EQ(run.points.front().representation, "pf3+pf5");
  const std::vector<FittedFunction> chosen = run.run(block).front();
  std::vector<MadeTheta> made(block.functions.size());
  ThetaPolicy(pointers, options).bake(block.stored.data(), block.count(), made.data());
  for (size_t i = 0; i < made.size(); ++i) {
    EXPECT_EQ(chosen[i].theta, made[i].theta) << "function " << i;
    EXPECT_EQ(chosen[i].representation.resolution, generators[made[i].generator]->representation().resolution);
  }
}

TEST(PointFigures, HaveNoneOfHardFunctionsWithoutAny) {
  ChosenFunctions functions = sampleFunctions();
  functions.hard.assign(6, false);
  PointMeasurement measured;
  measured.rmse.assign(6, 1.0);
  measured.blend_rmse.assign(6, 1.0);
  measured.fails_check.assign(6, false);
  measured.took_fit.assign(6, false);
  measured.times = {{0, {1, 2, 3, 4}}};
  EXPECT_FALSE(figuresOf(measured, sampleSet(), functions, sampleBlocks(), {}).figures[2]);
  EXPECT_FALSE(figuresOfTent(sampleSet(), functions, sampleTents()).figures[2]);
}

}  // namespace
}  // namespace nlg
