#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "tests/runtime_eval/sample_generator.h"
#include "tool/error.h"
#include "validate/frontier/choice_point.h"
#include "validate/frontier/fit_points.h"
#include "validate/frontier/frontier_json.h"
#include "validate/frontier/frontier_options.h"
#include "validate/frontier/generator_points.h"
#include "validate/frontier/interleaved.h"

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

std::vector<PointMeasurement> measureOnce(const std::vector<PlotPoint>& points) {
  return measureInterleaved(sampleSet(), sampleBlocks(), points, {0, 0.0}, [](int64_t) {});
}

// A point that gives the tent times 1 and notes what it was asked for.
struct Asked {
  std::vector<std::vector<uint64_t>> blocks;
  PlotPoint point(const std::string& label, double elapsed_us) {
    const auto run = [this, elapsed_us](const FunctionBlock& block) {
      blocks.push_back(block.functions);
      Theta theta(ThetaLayout::count, 0.0f);
      theta[ThetaLayout::b3] = 1.0f;
      return std::vector<FittedFunction>(block.functions.size(), {Representation::tentMlp(), theta, elapsed_us});
    };
    return {"tent_mlp", "generator", {}, label, true, run};
  }
};

TEST(Interleaved, RunsEveryPointOnTheSameFunctions) {
  Asked a, b;
  const std::vector<PointMeasurement> measured = measureOnce({a.point("a", 1), b.point("b", 2)});
  EXPECT_EQ(a.blocks, (std::vector<std::vector<uint64_t>>{{0, 1, 2, 3}, {4, 5}}));
  EXPECT_EQ(a.blocks, b.blocks);
  for (const PointMeasurement& point : measured) {
    ASSERT_EQ(point.errors.size(), size_t{kFunctionCount});
    for (int i = 1; i < kFunctionCount; ++i)
      EXPECT_LT(point.errors[i].rmse, point.errors[i - 1].rmse) << "walls stand further off";
  }
}

TEST(Interleaved, RepeatsShortPointsAndRunsLongOnesOnce) {
  Asked a;
  // a warming run before every one that counts; the first pass only measures errors
  const auto repeated = measureInterleaved(sampleSet(), sampleBlocks(), {a.point("a", 3)}, {4, 1e6}, [](int64_t) {});
  EXPECT_EQ(a.blocks.size(), 2u * (1 + 2 * 4));
  EXPECT_EQ(repeated.front().times.size(), 2u * 4);
  Asked b;
  const auto once = measureInterleaved(sampleSet(), sampleBlocks(), {b.point("b", 3)}, {4, 0.0}, [](int64_t) {});
  EXPECT_EQ(b.blocks.size(), 2u);
  EXPECT_EQ(once.front().times.size(), 2u);
  EXPECT_EQ(once.front().errors.size(), repeated.front().errors.size());
}

TEST(Interleaved, RefusesAnErrorThatIsNotFinite) {
  Asked a;
  PlotPoint point = a.point("broken", 1);
  point.run = [](const FunctionBlock& block) {
    return std::vector<FittedFunction>(block.functions.size(), {Representation::tentMlp(), Theta(ThetaLayout::count, NAN), 1.0});
  };
  EXPECT_THROW(measureOnce({point}), NumericalError);
}

TEST(PointFigures, AreMeansOfRunsAndQuantilesOverThem) {
  PointMeasurement measured;
  for (const double rmse : {1.0, 2.0, 3.0, 4.0, 5.0, 6.0}) measured.errors.push_back({rmse});
  measured.times = {{0, {1, 2, 3, 4}}, {1, {10, 20}}, {0, {3, 2, 1, 4}}};
  const PointFigures figures = figuresOf(measured, sampleBlocks(), sampleSet(), {false, true, false, true, true, false});
  EXPECT_EQ(figures.time.median_us, 2.5);
  EXPECT_EQ(figures.time.p25_us, 2.5);
  EXPECT_EQ(figures.time.p75_us, 0.5 * (2.5 + 15));
  EXPECT_EQ(figures.rmse.median, 3.5);
  EXPECT_EQ(figures.rmse.worst, 6.0);
  ASSERT_TRUE(figures.rmse_hard);
  EXPECT_EQ(figures.rmse_hard->median, 4.0);
  EXPECT_EQ(figures.rmse_hard->worst, 5.0);
  EXPECT_FALSE(figuresOf(measured, sampleBlocks(), sampleSet(), std::vector<bool>(6, false)).rmse_hard);
  const TentFigures tent =
      figuresOfTent({6, 5, 4, 3, 2, 1}, sampleBlocks(), sampleSet(), {true, true, false, false, false, false});
  EXPECT_EQ(tent.rmse.median, 3.5);
  EXPECT_EQ(tent.rmse_hard->mean, 5.5);
  EXPECT_EQ(tent.by_scene.at("hall").median, 4.0);
  // functions 0, 2 and 4 are the hall's: times 2, 10 and 2
  EXPECT_EQ(figures.by_scene.at("hall").time.median_us, 2.0);
  EXPECT_EQ(figures.by_scene.at("hall").rmse.median, 3.0);
  EXPECT_EQ(figures.by_scene.at("cellar").rmse.mean, 4.0);
}

GeneratorData sampleData(const Representation& representation) {
  return withCorrection(sampleGenerator(representation, 24, 3, 7), 16, 2, 2, 8);
}

std::shared_ptr<const Generator> sampleShared(const Representation& representation) {
  return std::make_shared<const Generator>(sampleData(representation));
}

std::vector<PlotPoint> pointsOfGenerator(const Representation& representation, const std::vector<int>& coefficients) {
  return generatorPoints(sampleData(representation), sampleShared(representation), {}, coefficients);
}

// First point of a family and budget.
const PlotPoint& find(const std::vector<PlotPoint>& points, const std::string& family, std::optional<int> budget = {}) {
  for (const PlotPoint& point : points) {
    if (point.family == family && point.budget == budget) return point;
  }
  throw std::runtime_error("no point of family " + family);
}

TEST(GeneratorPoints, MeasureWhatTheyAreNamedFor) {
  const std::vector<PlotPoint> points = pointsOfGenerator(Representation::tentMlp(), {5, 25});
  const FunctionBlock block = makeBlocks(sampleSet(), {0, 3, 5}).front();
  const auto theta = [&](const std::string& family, std::optional<int> budget = {}) {
    std::vector<Theta> thetas;
    for (const FittedFunction& function : find(points, family, budget).run(block)) {
      EXPECT_GT(function.elapsed_us, 0.0) << family;
      thetas.push_back(function.theta);
    }
    EXPECT_EQ(thetas.size(), 3u) << family;
    return thetas;
  };
  const std::vector<Theta> generated = theta("generator");
  EXPECT_EQ(generated, theta("precision", 32));
  EXPECT_EQ(generated, theta("coefficients", 25)) << "all of them";
  EXPECT_NE(generated, theta("coefficients", 5));
  EXPECT_NE(generated, theta("precision", 16));
  const std::vector<Theta> corrected = theta("corrected");
  EXPECT_EQ(corrected, theta("threads", 1));
  EXPECT_EQ(corrected, theta("threads", 2));
  EXPECT_EQ(corrected, theta("theta_precision", 32));
  const std::vector<Theta> half = theta("theta_precision", 16);
  EXPECT_NE(corrected, half);
  for (size_t i = 0; i < half.front().size(); ++i) {
    // half a unit in the last of float16's 11 bits, or of its smallest number
    EXPECT_NEAR(half.front()[i], corrected.front()[i], std::fabs(corrected.front()[i]) * 0x1p-11f + 0x1p-25f)
        << "parameter " << i;
  }
  EXPECT_FALSE(find(points, "threads", 2).may_be_on_front);
}

TEST(KeepCoefficients, LeavesTheLargestDeviationsAndSetsTheOthersToTheirMean) {
  const GeneratorData data = sampleData(Representation::tentMlp());
  const Generator all(data), some(keepCoefficients(data, 4));
  GeneratorScratch all_scratch(all), some_scratch(some);
  const int count = all.coefficientCount();
  std::vector<float> before(count), after(count);
  all.project(sampleSet().phi.data(), 1, before.data(), &all_scratch);
  some.project(sampleSet().phi.data(), 1, after.data(), &some_scratch);
  std::vector<float> largest = data.basis.deviation;
  std::sort(largest.rbegin(), largest.rend());
  for (int k = 0; k < count; ++k) {
    const bool is_kept = data.basis.deviation[k] >= largest[3];
    EXPECT_EQ(after[k], is_kept ? before[k] : 0.0f) << "coefficient " << k;
  }
}

TEST(FitPoints, StartWhereTheySayAndNeverEndAboveIt) {
  const auto run = std::make_shared<GeneratorRun>(sampleShared(Representation::tentMlp()));
  const std::vector<PlotPoint> fits = fitPoints(run, {{1, 4}, {16}, {8}, {64}}, 3);
  std::vector<PlotPoint> points = pointsOfGenerator(Representation::tentMlp(), {25});
  const size_t corrected = 1, first_fit = points.size();
  ASSERT_EQ(points[corrected].family, "corrected");
  points.insert(points.end(), fits.begin(), fits.end());
  const std::vector<PointMeasurement> measured = measureOnce(points);
  std::set<std::string> families;
  for (size_t p = first_fit; p < points.size(); ++p) {
    families.insert(points[p].family);
    for (int i = 0; i < kFunctionCount && points[p].family.ends_with("_generator"); ++i) {
      // fits read the kernels' sums, errors the evaluator's: the two differ by rounding
      EXPECT_LE(measured[p].errors[i].rmse, measured[corrected].errors[i].rmse * (1 + 1e-5)) << points[p].label << ", " << i;
    }
  }
  EXPECT_EQ(families, (std::set<std::string>{"lm_from_generator", "adam_from_generator", "lm_from_theta0", "adam_from_theta0",
                                             "lm_from_random", "adam_from_random"}));
  const FunctionBlock block = makeBlocks(sampleSet(), {0, 1}).front();
  const PlotPoint& random = find(fits, "lm_from_random", 8);
  EXPECT_EQ(random.run(block)[1].theta, random.run(block)[1].theta) << "the same start every time";
}

TEST(FitPoints, GiveProductFieldsAThirtySecondOfDirectAdamSteps) {
  const auto run = std::make_shared<GeneratorRun>(sampleShared(Representation::productField(3)));
  std::vector<int> budgets;
  for (const PlotPoint& point : fitPoints(run, {{}, {}, {}, {8, 16, 64, 320}}, 1)) {
    if (point.family == "adam_from_random") budgets.push_back(*point.budget);
  }
  EXPECT_EQ(budgets, (std::vector<int>{1, 2, 10}));
}

TEST(ChoicePoint, TakesForEveryFunctionAThetaThatOneGeneratorGave) {
  std::vector<std::shared_ptr<const Generator>> generators;
  for (const int r : {3, 5}) generators.push_back(sampleShared(Representation::productField(r)));
  const FunctionBlock block = makeBlocks(sampleSet(), {0, 1, 2, 3, 4, 5}).front();
  CorrectionOptions all;  // every theta is corrected …
  all.correct_rmse = 0.0;
  CheckOptions lenient;  // … and passes the check: what is chosen follows from the errors alone
  lenient.tau_rmse = 1e3, lenient.leak_share = 1.0;
  const auto chosenBy = [&](const ChoiceOptions& choice) {
    const PlotPoint point = choicePoint(generators, all, lenient, choice);
    EXPECT_EQ(point.representation, "pf3+pf5");
    return point.run(block);
  };
  ChoiceOptions never_larger, always_best;
  never_larger.flat_ratio = 1e6;
  always_best.flat_ratio = 1.0, always_best.enough_rmse = 0.0;
  const auto small = chosenBy(never_larger), best = chosenBy(always_best);
  std::vector<std::vector<FittedFunction>> generated;
  for (const auto& generator : generators) generated.push_back(GeneratorRun(generator, all).generateAndCorrect(block));
  for (size_t i = 0; i < block.functions.size(); ++i) {
    EXPECT_EQ(small[i].theta, generated[0][i].theta) << "function " << i;
    EXPECT_TRUE(best[i].theta == generated[0][i].theta || best[i].theta == generated[1][i].theta) << "function " << i;
    EXPECT_EQ(best[i].theta.size(), size_t(best[i].representation.thetaCount()));
  }
}

TEST(GeneratorPoints, VaryTheCorrectionOneSettingAtATime) {
  const auto budgets = [](const Representation& representation, const std::string& word) {
    std::vector<int> found;
    for (const PlotPoint& point : pointsOfGenerator(representation, {25})) {
      if (point.family == "corrected" && point.label.find(word) != std::string::npos) found.push_back(*point.budget);
    }
    return found;
  };
  const std::vector<int> all = {1, 2, 4, 8};
  EXPECT_EQ(budgets(Representation::tentMlp(), "learned step"), all);
  EXPECT_EQ(budgets(Representation::tentMlp(), "mirror image"), all);
  EXPECT_EQ(budgets(Representation::productField(3), "learned step"), all);
  EXPECT_EQ(budgets(Representation::productField(3), "LM iteration"), all);
}

TEST(FrontierOptions, RefuseListsThatDoNotRise) {
  for (const char* wrong : {"0", "-1", "1.5", "x", "", "99999999"}) {
    FrontierOptions options;
    options.lm_steps = {wrong};
    EXPECT_THROW(options.budgets(), UsageError) << wrong;
  }
  FrontierOptions options;
  options.direct_adam_steps = {"2", "2"};
  EXPECT_THROW(options.budgets(), UsageError);
  options.direct_adam_steps = {"2", "3"};
  EXPECT_EQ(options.budgets().direct_adam, (std::vector<int>{2, 3}));
  EXPECT_TRUE(options.coefficientCounts().empty());
}

}  // namespace
}  // namespace nlg
