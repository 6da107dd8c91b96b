#include "validate/compare/comparison.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include <nlohmann/json.hpp>

#include "runtime_eval/numbers/random.h"
#include "tool/error.h"
#include "validate/compare/paired_figures.h"

namespace nlg {
namespace {

constexpr int kFunctions = 400;
const std::string kScenes[] = {"quiet", "a \"quoted\", one"};

// A folder with summary.json and functions.csv of made-up errors; new_rmse changes the error of one function under a method.
class ComparisonTest : public testing::Test {
 protected:
  using Errors = std::function<double(int function, double rmse)>;

  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, const Errors& changed, bool with_functions = true,
                    const std::string& held_out = "aa") {
    Random random(7);
    std::string csv =
        "representation,method,function,scene,hard,rmse,rmse_unseen_points,rmse_shadow,leak_mean,leak_p99,elapsed_us\n";
    nlohmann::ordered_json methods;
    for (const char* method : kComparedMethods) {
      double sum = 0.0, worst = 0.0;
      for (int i = 0; i < kFunctions; ++i) {
        const double rmse = changed(i, 0.001 + 0.02 * random.uniform());
        sum += rmse;
        worst = std::max(worst, rmse);
        const std::string scene = i % 2 == 0 ? "quiet" : "\"a \"\"quoted\"\", one\"";
        csv += std::string("mlp,") + method + "," + std::to_string(i) + "," + scene + "," + (i % 3 == 0 ? "1" : "0") + "," +
               std::to_string(rmse) + ",0,,0.01,0.05,12\n";
      }
      methods[method] = {
          {"functions", kFunctions},       {"rmse", {{"mean", sum / kFunctions}, {"p99", sum / kFunctions}, {"worst", worst}}},
          {"rmse_hard", {{"mean", 0.01}}}, {"share_over_tau", 0.1},
          {"leak", {{"mean", 0.001}}},     {"us_per_function", 12.0}};
    }
    methods["by_scene"] = {{kScenes[0], {{"mean", 0.01}}}, {kScenes[1], {{"mean", 0.01}}}};
    const nlohmann::ordered_json summary = {{"schema_version", 1},
                                            {"provenance", {{"inputs", {{"held_out", held_out}}}}},
                                            {"tau", {{"rmse", 0.02}, {"leak_p99", 0.1}, {"hard_tent_rmse", 0.01}}},
                                            {"representations", {{"mlp", methods}}}};
    std::filesystem::create_directories(folder_ + "/" + name);
    std::ofstream(folder_ + "/" + name + "/summary.json") << summary.dump();
    if (with_functions) std::ofstream(folder_ + "/" + name + "/functions.csv") << csv;
    return folder_ + "/" + name + "/summary.json";
  }

  static Change change(const Comparison& comparison, const std::string& figure, const std::string& scene = "") {
    for (const Change& some : comparison.changes) {
      if (some.figure == figure && some.scene == scene) return some;
    }
    ADD_FAILURE() << "no figure '" << figure << "' of scene '" << scene << "'";
    return {};
  }

  const std::string folder_ = testing::TempDir() + "nlg_comparison_" + std::to_string(getpid());
  const Errors same_ = [](int, double rmse) { return rmse; };
};

TEST_F(ComparisonTest, FindsNothingBetweenARunAndItself) {
  const ValidationResult run = readValidation(write("old", same_));
  const Comparison comparison = compare(run, run, {});
  EXPECT_TRUE(comparison.is_paired);
  ASSERT_FALSE(comparison.changes.empty());
  for (const Change& some : comparison.changes) EXPECT_EQ(some.trend, Trend::same) << some.figure << " of '" << some.scene << "'";
}

TEST_F(ComparisonTest, SeesASmallChangeThatAllFunctionsShare) {
  // 3 %: below what the spread over functions would hide if they were not paired
  const ValidationResult old_run = readValidation(write("old", same_));
  const ValidationResult worse = readValidation(write("new", [](int, double rmse) { return 1.03 * rmse; }));
  const Change there = change(compare(old_run, worse, {}), "generator, mean RMSE");
  EXPECT_EQ(there.trend, Trend::worse);
  EXPECT_NEAR(there.new_value / there.old_value, 1.03, 1e-3);  // six decimals of a value of .01
  EXPECT_EQ(change(compare(worse, old_run, {}), "generator, mean RMSE").trend, Trend::better);
}

TEST_F(ComparisonTest, CallsNoiseTheSame) {
  // every function changes by up to 30 %, in either direction alike: the mean of the paired differences is within their noise
  Random random(11);
  const ValidationResult old_run = readValidation(write("old", same_));
  const ValidationResult noisy =
      readValidation(write("new", [&](int, double rmse) { return rmse * (1.0 + 0.6 * (random.uniform() - 0.5)); }));
  for (const Change& some : compare(old_run, noisy, {}).changes)
    EXPECT_EQ(some.trend, Trend::same) << some.figure << " of '" << some.scene << "'";
}

TEST_F(ComparisonTest, NamesTheSceneThatGotWorse) {
  const ValidationResult old_run = readValidation(write("old", same_));
  const ValidationResult worse = readValidation(write("new", [](int i, double rmse) { return i % 2 == 1 ? 1.2 * rmse : rmse; }));
  const Comparison comparison = compare(old_run, worse, {});
  EXPECT_EQ(change(comparison, "refined, mean RMSE", kScenes[1]).trend, Trend::worse);
  EXPECT_EQ(change(comparison, "refined, mean RMSE", kScenes[0]).trend, Trend::same);
}

TEST_F(ComparisonTest, CountsFunctionsThatCrossTau) {
  // one function in ten rises above .02
  const ValidationResult old_run = readValidation(write("old", [](int, double rmse) { return 0.5 * rmse; }));
  const ValidationResult worse = readValidation(write("new", [](int i, double rmse) { return i % 10 == 0 ? 0.03 : 0.5 * rmse; }));
  const Change there = change(compare(old_run, worse, {}), "generator, share over tau");
  EXPECT_EQ(there.old_value, 0.0);
  EXPECT_DOUBLE_EQ(there.new_value, 0.1);
  EXPECT_EQ(there.trend, Trend::worse);
}

TEST_F(ComparisonTest, FallsBackToTheToleranceWithoutFunctions) {
  const ValidationResult old_run = readValidation(write("old", same_, false));
  const ValidationResult slightly = readValidation(write(
      "slightly", [](int, double rmse) { return 1.04 * rmse; }, false));
  const ValidationResult clearly = readValidation(write(
      "clearly", [](int, double rmse) { return 1.06 * rmse; }, false));
  EXPECT_FALSE(compare(old_run, slightly, {}).is_paired);
  EXPECT_EQ(change(compare(old_run, slightly, {}), "generator, mean RMSE").trend, Trend::same);
  EXPECT_EQ(change(compare(old_run, clearly, {}), "generator, mean RMSE").trend, Trend::worse);
  EXPECT_EQ(change(compare(old_run, clearly, {}), "generator, p99 of RMSE").trend, Trend::worse);
  EXPECT_EQ(change(compare(old_run, clearly, {}), "generator, worst RMSE").trend, Trend::same);
  const ValidationResult leapt = readValidation(write(
      "leapt", [](int i, double rmse) { return i == 5 ? 0.9 : rmse; }, false));
  EXPECT_EQ(change(compare(old_run, leapt, {}), "generator, worst RMSE").trend, Trend::worse);
}

TEST_F(ComparisonTest, JudgesTimesOnlyWhenAsked) {
  ValidationResult old_run = readValidation(write("old", same_)), slow = old_run;
  slow.representations[0].figures["generator"].us_per_function *= 3.0;
  EXPECT_EQ(change(compare(old_run, slow, {}), "generator, µs a function").trend, Trend::same);
  ComparisonOptions options;
  options.time_tolerance = 0.5;
  EXPECT_EQ(change(compare(old_run, slow, options), "generator, µs a function").trend, Trend::worse);
}

TEST_F(ComparisonTest, RefusesOtherFunctionsAndOtherThresholds) {
  const ValidationResult old_run = readValidation(write("old", same_));
  EXPECT_THROW(compare(old_run, readValidation(write("other", same_, true, "bb")), {}), InputError);
  ValidationResult other = old_run;
  other.tau["rmse"] = 0.03;
  EXPECT_THROW(compare(old_run, other, {}), InputError);
  other = old_run;
  other.representations[0].functions["generator"][3].scene = "elsewhere";
  EXPECT_THROW(compare(old_run, other, {}), InputError);
  other = old_run;
  other.representations[0].name = "pf3";
  EXPECT_THROW(compare(old_run, other, {}), InputError);
}

TEST_F(ComparisonTest, TellsWhichRepresentationIsLost) {
  ValidationResult old_run = readValidation(write("old", same_)), new_run = old_run;
  old_run.representations.push_back(old_run.representations[0]);
  old_run.representations[1].name = "pf3";
  EXPECT_EQ(compare(old_run, new_run, {}).lost, std::vector<std::string>{"pf3"});
  EXPECT_EQ(compare(new_run, old_run, {}).added, std::vector<std::string>{"pf3"});
}

TEST_F(ComparisonTest, RefusesDamagedFiles) {
  const std::string path = write("old", same_);
  const std::string functions = folder_ + "/old/functions.csv";
  EXPECT_THROW(readValidation(folder_ + "/missing/summary.json"), InputError);
  std::filesystem::resize_file(functions, std::filesystem::file_size(functions) / 2);
  EXPECT_THROW(readValidation(path), InputError);
  std::ofstream(functions) << "a,b\n1,2\n";
  EXPECT_THROW(readValidation(path), InputError);
  for (const char* text : {"", "[]", "{\"schema_version\": 2}", "{\"schema_version\": 1}", "{\"schema_version\": \"1\"}"}) {
    std::ofstream(path) << text;
    EXPECT_THROW(readValidation(path), InputError) << text;
  }
}

TEST_F(ComparisonTest, SeesOneFunctionThatLeaps) {
  const ValidationResult old_run = readValidation(write("old", same_));
  ValidationResult tail = old_run;
  tail.representations[0].functions["refined"][7].rmse = 0.9;
  const Comparison comparison = compare(old_run, tail, {});
  const Change worst = change(comparison, "refined, worst RMSE");
  EXPECT_EQ(worst.trend, Trend::worse);
  EXPECT_EQ(worst.new_value, 0.9);
  EXPECT_NE(worst.note.find("function 7 of"), std::string::npos) << worst.note;
  EXPECT_EQ(change(comparison, "refined, worst RMSE", kScenes[1]).trend, Trend::worse);
  EXPECT_EQ(change(comparison, "refined, worst RMSE", kScenes[0]).trend, Trend::same);
  EXPECT_EQ(change(comparison, "generator, worst RMSE").trend, Trend::same);
  EXPECT_EQ(change(compare(tail, old_run, {}), "refined, worst RMSE").trend, Trend::better);
  // up to the factor, of tau or of its own error, it is not
  tail.representations[0].functions["refined"][7].rmse = 0.0399;
  EXPECT_EQ(change(compare(old_run, tail, {}), "refined, worst RMSE").trend, Trend::same);
}

TEST_F(ComparisonTest, SeesATailThatRisesWhileTheMeanStays) {
  // 20 of 400 go to twice the highest, all others fall so that the mean stays; p99 of both runs together lies among the 20
  const ValidationResult old_run = readValidation(write("old", same_));
  ValidationResult tail = old_run;
  for (ComparedFunction& function : tail.representations[0].functions["refined"]) {
    function.rmse = function.function % 20 == 0 ? 0.035 + 1e-5 * function.function : 0.88 * function.rmse;
  }
  const Comparison comparison = compare(old_run, tail, {});
  const Change p99 = change(comparison, "refined, p99 of RMSE");
  EXPECT_NEAR(p99.old_value, 0.0208, 0.0003);  // uniform in [.001, .021]
  EXPECT_GT(p99.new_value, 0.035);
  EXPECT_NEAR(*p99.chance, std::pow(2.0, 1.0 - 8.0), 1e-12);  // 1 % of 800 are above it, all of the new run
  EXPECT_EQ(change(comparison, "refined, mean RMSE").trend, Trend::same);
  ComparisonOptions lax;  // so few functions say little of a p99
  lax.false_alarms = 0.5;
  EXPECT_EQ(change(compare(old_run, tail, lax), "refined, p99 of RMSE").trend, Trend::worse);
}

TEST_F(ComparisonTest, NoiseAloneSeldomHasAnythingCalledChanged) {
  // every function's two errors are drawn alike; scenes of 8 functions, whose spread is poorly known
  constexpr int kRuns = 1000, kScenesOfEight = 12;
  Random random(5);
  int alarms = 0;
  for (int i = 0; i < kRuns; ++i) {
    ValidationResult runs[2];
    for (ValidationResult& run : runs) {
      run.held_out = "aa";
      run.has_functions = true;
      run.tau = {{"rmse", 0.02}, {"leak_p99", 0.1}};
      ComparedRepresentation one;
      for (const char* method : kComparedMethods) {
        one.figures[method] = {};
        for (int f = 0; f < 8 * kScenesOfEight; ++f) {
          const std::string scene = "scene " + std::to_string(f / 8);
          one.scene_rmse[scene] = 0.0;
          one.functions[method].push_back(
              {static_cast<uint64_t>(f), scene, f % 2 == 0, std::abs(0.015 + 0.003 * random.normal()), random.uniform(), 0.0});
        }
      }
      run.representations.push_back(one);
    }
    ComparisonOptions options;
    options.smallest_change = 0.0;
    const Comparison comparison = compare(runs[0], runs[1], options);
    EXPECT_EQ(comparison.judged_by_chance, 2u * (5 + 2 * kScenesOfEight));
    bool alarm = false;
    for (const Change& some : comparison.changes) alarm |= some.trend != Trend::same;
    alarms += alarm;
  }
  // at most 5 %; 4 standard deviations of the count of 1000 more
  EXPECT_LE(alarms, 50 + 4 * std::sqrt(1000 * 0.05 * 0.95));
}

TEST(MeanChange, FollowsStudentWithTheNumberOfPairs) {
  // differences 1 and 3, ten of each: mean 2, variance 20/19, standard error sqrt(1/19)
  std::vector<double> old_values(20, 100.0), new_values;
  for (int i = 0; i < 20; ++i) new_values.push_back(i % 2 == 0 ? 101 : 103);
  const Change there = meanChange(old_values, new_values);
  EXPECT_DOUBLE_EQ(there.new_value, 102.0);
  EXPECT_NEAR(there.standard_error, std::sqrt(1.0 / 19.0), 1e-12);
  // t = 8.7 of 19 degrees of freedom would be 5e-8
  EXPECT_EQ(there.chance, std::optional<double>(std::pow(2.0, -19.0)));
  // differences -2 and 3, four of each: mean .5, variance 50/7, t = .5 / sqrt(50/56) = .52915; by Simpson's rule of 7 degrees: .6131
  const Change unsure = meanChange(std::vector<double>(8, 10.0), {8, 13, 8, 13, 8, 13, 8, 13});
  EXPECT_NEAR(*unsure.chance, 0.6131, 1e-4);
}

TEST(P99Change, IsTheSignTestAtThePercentileOfBothRuns) {
  // 2000 functions from 0 to 1; 60 of the best become the worst: the highest 1 % of 4000 are 40 of these, and none falls
  std::vector<double> old_values, new_values;
  for (int i = 0; i < 2000; ++i) {
    old_values.push_back(i / 2000.0);
    new_values.push_back(i < 60 ? 2.0 + i : i / 2000.0);
  }
  const Change there = p99Change(old_values, new_values);
  EXPECT_NEAR(there.old_value, 0.99 * 1999 / 2000.0, 1e-12);
  EXPECT_NEAR(there.new_value, 2.0 + 0.99 * 1999 - 1940, 1e-9);
  EXPECT_NEAR(*there.chance / std::pow(2.0, -39.0), 1.0, 1e-9);
  EXPECT_NEAR(*p99Change(new_values, old_values).chance / std::pow(2.0, -39.0), 1.0, 1e-9);
  // thirty that change places with the worst thirty: as many up as down
  std::vector<double> swapped = old_values;
  for (int i = 0; i < 30; ++i) std::swap(swapped[i], swapped[1999 - i]);
  EXPECT_EQ(p99Change(old_values, swapped).chance, std::optional<double>(1.0));
}

TEST(MeanChange, KnowsNothingFromOnePair) {
  EXPECT_EQ(meanChange({1.0}, {9.0}).chance, std::optional<double>(1.0));
  EXPECT_EQ(meanChange({1.0, 1.0}, {9.0, 9.0}).chance, std::optional<double>(0.5));
  EXPECT_EQ(meanChange({1.0, 2.0}, {1.0, 2.0}).chance, std::optional<double>(1.0));
  EXPECT_FALSE(meanChange({}, {}).chance);
}

}  // namespace
}  // namespace nlg
