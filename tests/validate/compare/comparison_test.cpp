#include "validate/compare/comparison.h"

#include <fmt/format.h>
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
constexpr double kTauRmse = 0.02;
const std::string kScenes[] = {"quiet", "a \"quoted\", one"};

// A folder with summary.json and functions.csv of made-up errors; new_rmse changes the error of one function at every stage.
class ComparisonTest : public testing::Test {
 protected:
  using Errors = std::function<double(int function, double rmse)>;

  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, const Errors& changed, bool with_functions = true,
                    const std::string& held_out = "aa") {
    Random random(7);
    std::string csv =
        "representation,word,function,scene,take_theta,hard,rmse,rmse_test_points,rmse_occluded,leak_mean,leak_p99,fails_check,"
        "fitted,elapsed_us\n";
    nlohmann::ordered_json words;
    for (const char* word : kComparedWords) {
      double sum = 0.0, worst = 0.0;
      for (int i = 0; i < kFunctions; ++i) {
        const double rmse = changed(i, 0.001 + 0.02 * random.uniform());
        sum += rmse;
        worst = std::max(worst, rmse);
        const std::string scene = i % 2 == 0 ? "quiet" : "\"a \"\"quoted\"\", one\"";
        csv += fmt::format("mlp,{},{},{},1,{},{:.6f},0,,0.01,0.05,{:d},0,12\n", word, i, scene, i % 3 == 0 ? 1 : 0, rmse,
                           rmse > kTauRmse);
      }
      // what takes no theta is the bare tent in every run: it must not count
      csv += fmt::format("mlp,{},{},quiet,0,0,{},0,,9,9,0,0,0\n", word, kFunctions, changed(0, 0.5));
      const nlohmann::ordered_json figures = {
          {"functions", kFunctions},          {"rmse", {{"mean", sum / kFunctions}, {"p99", sum / kFunctions}, {"worst", worst}}},
          {"leak", {{"mean", 0.001}}},        {"share_failing_check", {{"value", 0.1}}},
          {"share_fitted", {{"value", 0.2}}}, {"us_per_function", 12.0}};
      words[word] = {{"all", {{"functions", kFunctions + 1}}}, {"theta", figures}, {"hard", {{"rmse", {{"mean", 0.01}}}}}};
    }
    const nlohmann::ordered_json of_scene = {{"network", {{"mean", 0.01}}}, {"stored", {{"mean", 0.01}}}};
    words["by_scene"] = {{kScenes[0], of_scene}, {kScenes[1], of_scene}};
    const nlohmann::ordered_json summary = {
        {"schema_version", 2},
        {"provenance", {{"inputs", {{"held_out", held_out}}}}},
        {"theta_precision", "int8"},
        {"tau", {{"rmse", kTauRmse}, {"leak", 0.1}, {"leak_share", 0.01}, {"hard_tent_rmse", 0.01}, {"bare_tent_rmse", 0.002}}},
        {"representations", {{"mlp", words}}}};
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
  const Change there = change(compare(old_run, worse, {}), "network, mean RMSE");
  EXPECT_EQ(there.trend, Trend::worse);
  EXPECT_NEAR(there.new_value / there.old_value, 1.03, 1e-3);  // six decimals of a value of .01
  EXPECT_EQ(change(compare(worse, old_run, {}), "network, mean RMSE").trend, Trend::better);
}

TEST_F(ComparisonTest, CallsNoiseTheSame) {
  // either run's errors are off by up to 30 %, so that each function's two could as well stand the other way round
  Random random(11);
  const Errors noise = [&](int, double rmse) { return rmse * (1.0 + 0.6 * (random.uniform() - 0.5)); };
  const ValidationResult old_run = readValidation(write("old", noise)), noisy = readValidation(write("new", noise));
  for (const Change& some : compare(old_run, noisy, {}).changes)
    EXPECT_EQ(some.trend, Trend::same) << some.figure << " of '" << some.scene << "'";
}

TEST_F(ComparisonTest, NamesTheSceneThatGotWorse) {
  const ValidationResult old_run = readValidation(write("old", same_));
  const ValidationResult worse = readValidation(write("new", [](int i, double rmse) { return i % 2 == 1 ? 1.2 * rmse : rmse; }));
  const Comparison comparison = compare(old_run, worse, {});
  EXPECT_EQ(change(comparison, "stored, mean RMSE", kScenes[1]).trend, Trend::worse);
  EXPECT_EQ(change(comparison, "stored, mean RMSE", kScenes[0]).trend, Trend::same);
}

TEST_F(ComparisonTest, CountsFunctionsThatComeToFailTheCheck) {
  // one function in ten rises above .02
  const ValidationResult old_run = readValidation(write("old", [](int, double rmse) { return 0.5 * rmse; }));
  const ValidationResult worse = readValidation(write("new", [](int i, double rmse) { return i % 10 == 0 ? 0.03 : 0.5 * rmse; }));
  const Change there = change(compare(old_run, worse, {}), "network, share that fails the check");
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
  EXPECT_EQ(change(compare(old_run, slightly, {}), "network, mean RMSE").trend, Trend::same);
  EXPECT_EQ(change(compare(old_run, clearly, {}), "network, mean RMSE").trend, Trend::worse);
  EXPECT_EQ(change(compare(old_run, clearly, {}), "network, p99 of RMSE").trend, Trend::worse);
  EXPECT_EQ(change(compare(old_run, clearly, {}), "network, worst RMSE").trend, Trend::same);
  const ValidationResult leapt = readValidation(write(
      "leapt", [](int i, double rmse) { return i == 5 ? 0.9 : rmse; }, false));
  EXPECT_EQ(change(compare(old_run, leapt, {}), "network, worst RMSE").trend, Trend::worse);
}

TEST_F(ComparisonTest, JudgesTimesOnlyWhenAsked) {
  ValidationResult old_run = readValidation(write("old", same_)), slow = old_run;
  slow.representations[0].figures["network"].us_per_function *= 3.0;
  EXPECT_EQ(change(compare(old_run, slow, {}), "network, µs a function").trend, Trend::same);
  ComparisonOptions options;
  options.time_tolerance = 0.5;
  EXPECT_EQ(change(compare(old_run, slow, options), "network, µs a function").trend, Trend::worse);
}

TEST_F(ComparisonTest, RefusesOtherFunctionsAndOtherThresholds) {
  const ValidationResult old_run = readValidation(write("old", same_));
  EXPECT_THROW(compare(old_run, readValidation(write("other", same_, true, "bb")), {}), InputError);
  ValidationResult other = old_run;
  other.tau["rmse"] = 0.03;
  EXPECT_THROW(compare(old_run, other, {}), InputError);
  other = old_run;
  other.theta_precision = "float32";
  EXPECT_THROW(compare(old_run, other, {}), InputError);
  other = old_run;
  other.representations[0].functions["network"][3].scene = "elsewhere";
  EXPECT_THROW(compare(old_run, other, {}), InputError);
  other = old_run;
  other.representations[0].name = "pf3";
  EXPECT_THROW(compare(old_run, other, {}), InputError);
}

TEST_F(ComparisonTest, LeavesFunctionsThatTakeNoThetaOut) {
  const ValidationResult old_run = readValidation(write("old", same_));
  ValidationResult other = old_run;
  for (const char* word : kComparedWords) other.representations[0].functions[word].back().rmse = 0.9;
  for (const Change& some : compare(old_run, other, {}).changes) EXPECT_EQ(some.old_value, some.new_value) << some.figure;
}

TEST_F(ComparisonTest, RefusesAnotherSchemaInOneLine) {
  const std::string path = write("old", same_);
  std::ofstream(path) << R"({"schema_version": 1})";
  try {
    readValidation(path);
    ADD_FAILURE() << "taken";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("the same schema only, got 1"), std::string::npos) << error.what();
  }
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
  for (const char* text : {"", "[]", "{\"schema_version\": 1}", "{\"schema_version\": 2}", "{\"schema_version\": \"2\"}"}) {
    std::ofstream(path) << text;
    EXPECT_THROW(readValidation(path), InputError) << text;
  }
}

TEST_F(ComparisonTest, SeesOneFunctionThatLeaps) {
  const ValidationResult old_run = readValidation(write("old", same_));
  ValidationResult tail = old_run;
  tail.representations[0].functions["stored"][7].rmse = 0.9;
  const Comparison comparison = compare(old_run, tail, {});
  const Change worst = change(comparison, "stored, worst RMSE");
  EXPECT_EQ(worst.trend, Trend::worse);
  EXPECT_EQ(worst.new_value, 0.9);
  EXPECT_NE(worst.note.find("function 7 of"), std::string::npos) << worst.note;
  EXPECT_EQ(change(comparison, "stored, worst RMSE", kScenes[1]).trend, Trend::worse);
  EXPECT_EQ(change(comparison, "stored, worst RMSE", kScenes[0]).trend, Trend::same);
  EXPECT_EQ(change(comparison, "network, worst RMSE").trend, Trend::same);
  EXPECT_EQ(change(compare(tail, old_run, {}), "stored, worst RMSE").trend, Trend::better);
  // up to the factor, of tau or of its own error, it is not
  tail.representations[0].functions["stored"][7].rmse = 0.0399;
  EXPECT_EQ(change(compare(old_run, tail, {}), "stored, worst RMSE").trend, Trend::same);
}

TEST_F(ComparisonTest, SeesATailThatRisesWhileTheMeanStays) {
  // 20 of 400 go to twice the highest, all others fall so that the mean stays; p99 of both runs together lies among the 20
  const ValidationResult old_run = readValidation(write("old", same_));
  ValidationResult tail = old_run;
  for (ComparedFunction& function : tail.representations[0].functions["stored"]) {
    function.rmse = function.function % 20 == 0 ? 0.035 + 1e-5 * function.function : 0.88 * function.rmse;
  }
  const Comparison comparison = compare(old_run, tail, {});
  const Change p99 = change(comparison, "stored, p99 of RMSE");
  EXPECT_NEAR(p99.old_value, 0.0208, 0.0003);  // uniform in [.001, .021]
  EXPECT_GT(p99.new_value, 0.035);
  EXPECT_NEAR(*p99.chance, std::pow(2.0, 1.0 - 8.0), 1e-12);  // 1 % of 800 are above it, all of the new run
  EXPECT_EQ(change(comparison, "stored, mean RMSE").trend, Trend::same);
  ComparisonOptions lax;  // so few functions say little of a p99
  lax.false_alarms = 0.5;
  EXPECT_EQ(change(compare(old_run, tail, lax), "stored, p99 of RMSE").trend, Trend::worse);
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
      run.tau = {{"rmse", kTauRmse}};
      ComparedRepresentation one;
      for (const char* word : kComparedWords) {
        one.figures[word] = {};
        for (int f = 0; f < 8 * kScenesOfEight; ++f) {
          const std::string scene = "scene " + std::to_string(f / 8);
          const double rmse = std::abs(0.015 + 0.003 * random.normal());
          one.scene_rmse[scene] = {};
          one.functions[word].push_back(
              {static_cast<uint64_t>(f), scene, true, f % 2 == 0, rmse, random.uniform(), rmse > kTauRmse});
        }
      }
      run.representations.push_back(one);
    }
    ComparisonOptions options;
    options.smallest_change = 0.0;
    const Comparison comparison = compare(runs[0], runs[1], options);
    EXPECT_EQ(comparison.judged_by_chance, 4u * 5 + 2u * 2 * kScenesOfEight);
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
