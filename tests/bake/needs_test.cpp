// What a scene does not need: the lines' counts add up, and what they claim to be saved is what a bake without the saving takes.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <set>

#include "bake/look_up_difference.h"
#include "bake/needs_measurement.h"
#include "tests/runtime_eval/sample_generator.h"

namespace nlg {
namespace {

std::string spoolFolder() { return std::filesystem::temp_directory_path().string(); }

// All of a text, in their order; a test of a note's figures leaves its words alone.
std::vector<double> numbersIn(const std::string& text) {
  std::vector<double> numbers;
  for (const char* at = text.c_str(); *at != '\0';) {
    char* end = nullptr;
    const bool is_digit = *at >= '0' && *at <= '9';
    if (is_digit) numbers.push_back(std::strtod(at, &end));
    at = is_digit ? end : at + 1;
  }
  return numbers;
}

std::vector<Generator> generators(const std::vector<std::string>& names) {
  std::vector<Generator> result;
  for (const std::string& name : names) {
    Representation representation;
    EXPECT_TRUE(findRepresentation(name, &representation)) << name;
    GeneratorData data = withCorrection(sampleGenerator(representation, 24, 3, 1), 20, 3, 2, 1);
    result.emplace_back(data);
  }
  return result;
}

// A corner of a house: of every kind of probe but those that are 0 everywhere. Not refined unless a test asks for it.
BakeOptions houseOptions() {
  BakeOptions options;
  options.spacing_m = 1.5;
  options.extent_m = {"0", "0", "0", "6", "6", "3"};
  options.refinement.rounds = 0;
  options.refinement.first_steps = 4;
  options.threads = 2;
  return options;
}

// Duplicates are the same bytes: whether two functions share a theta does not depend on what else is left out.
BakeOptions exactOptions() {
  BakeOptions options = houseOptions();
  options.duplicate_rms = 0.0;
  options.duplicate_validity_points = 0;
  return options;
}

const BakeScene& house() {
  static const BakeScene scene("house:3", houseOptions());
  return scene;
}

Bake bakeHouse(const std::vector<Generator>& generators, const BakeOptions& options, const BakeSavings& savings = {}) {
  return bakeScene(house(), generators, options, ThetaPrecision::float32, spoolFolder(), savings);
}

std::string fileBytes(const LightGrid& grid) {
  std::string bytes;
  const WeightsResult result = serializeLightGrid(grid, ThetaPrecision::float32, {}, &bytes);
  EXPECT_TRUE(result.ok()) << result.detail;
  return bytes;
}

uint64_t probesOf(const LightGrid& grid, uint32_t function) {
  return static_cast<uint64_t>(std::count(grid.probe_function.begin(), grid.probe_function.end(), function));
}

// The median error of what generators make, nothing corrected.
double medianRmse(const std::vector<Generator>& generators, BakeOptions options) {
  options.correction.correct_rmse = 1e3;
  options.refinement.check = {1e3, 1e3, 1.0};
  std::vector<double> rmse;
  for (const FunctionCheck& check : bakeHouse(generators, options).statistics.stored) rmse.push_back(check.rmse);
  std::sort(rmse.begin(), rmse.end());
  return rmse[rmse.size() / 2];
}

TEST(Needs, CountsAreThoseOfTheBakeAndAddUp) {
  const std::vector<Generator> both = generators({"tent_mlp", "mlp"});
  const Bake bake = bakeHouse(both, houseOptions());
  std::vector<Need> needs = countNeeds(bake, both, ThetaPrecision::float32, {1000, 2000});
  const ShardCounts& counts = bake.statistics.counts;
  const auto line = [&](const char* what) -> const Need& {
    Need* need = findNeed(needs, what);
    EXPECT_NE(need, nullptr) << what;
    return *need;
  };
  EXPECT_GT(line(need::kFreeSpace).count, 0u);
  EXPECT_GT(line(need::kDuplicates).count, 0u);
  EXPECT_GT(line(need::kBareTent).count, 0u);
  EXPECT_EQ(line(need::kFreeSpace).count + line(need::kBareTent).count, probesOf(bake.grid, kFreeSpace));
  EXPECT_EQ(line(need::kInSolid).count + line(need::kEmpty).count, probesOf(bake.grid, kNoWeight));
  const uint64_t parts = line(need::kFreeSpace).count + line(need::kInSolid).count + line(need::kEmpty).count +
                         line(need::kDuplicates).count + line(need::kBareTent).count;
  EXPECT_EQ(line(need::kAllProbes).count, parts);
  EXPECT_EQ(parts + counts.functions, counts.grid_probes);
  EXPECT_EQ(line(need::kLargestTheta).count + bake.statistics.chosen.back(), counts.functions);
  EXPECT_EQ(line(need::kRefinement).count + bake.statistics.failed_check, counts.functions);
  // the smaller generator ran for all functions, the larger for those that it was not enough for
  EXPECT_EQ(line(need::kCorrection).of, 2 * counts.functions - bake.statistics.smallest_enough);
  uint64_t never_bytes = 0;
  for (size_t g = 0; g < both.size(); ++g) never_bytes += bake.statistics.chosen[g] == 0 ? 1000 * (g + 1) : 0;
  EXPECT_EQ(line(need::kNeverChosen).bytes_saved, static_cast<int64_t>(never_bytes));
  for (const Need& need : needs) {
    EXPECT_LE(need.count, need.of) << need.what;
    EXPECT_FALSE(need.seconds_saved) << need.what << ": nothing was measured";
    EXPECT_FALSE(need.same_result) << need.what << ": nothing was compared";
    EXPECT_FALSE(need.note.empty()) << need.what;
  }
}

TEST(Needs, TablesHaveEveryLineAndTheKeysOfTheReport) {
  const std::vector<Generator> one = generators({"tent_mlp"});
  const std::vector<Need> needs = countNeeds(bakeHouse(one, houseOptions()), one, ThetaPrecision::float32, {1000});
  const nlohmann::ordered_json json = toJson(needs);
  const std::string text = toTable(needs);
  ASSERT_EQ(json.size(), needs.size());
  std::set<std::string> names;
  for (size_t i = 0; i < needs.size(); ++i) {
    for (const char* key :
         {"what", "left_out", "count", "of", "seconds_saved", "seconds_noise", "bytes_saved", "same_result", "note"}) {
      EXPECT_TRUE(json[i].contains(key)) << needs[i].what << ": " << key;
    }
    EXPECT_NE(text.find(needs[i].what), std::string::npos) << text;
    EXPECT_TRUE(names.insert(needs[i].what).second) << needs[i].what << " stands there twice";
  }
  EXPECT_TRUE(json.back().at("left_out").is_null()) << "there is no lighting to leave out";
  EXPECT_EQ(json.back().at("what"), need::kLighting);
}

TEST(BakeSavings, FreeSpaceIsOneFunctionForAllOfIt) {
  const std::vector<Generator> one = generators({"tent_mlp"});
  BakeOptions options = exactOptions();
  options.bare_tent_rmse = 0.0;
  const Bake with = bakeHouse(one, options), without = bakeHouse(one, options, {.free_space = false});
  ASSERT_GT(probesOf(with.grid, kFreeSpace), 0u);
  EXPECT_EQ(probesOf(without.grid, kFreeSpace), 0u);
  // the bare tent: one more distinct function, unless some other probe has it too
  EXPECT_LE(without.grid.functionCount(), with.grid.functionCount() + 1);
  std::set<uint32_t> functions;
  for (size_t p = 0; p < with.grid.probe_function.size(); ++p) {
    if (with.grid.probe_function[p] == kFreeSpace) functions.insert(without.grid.probe_function[p]);
  }
  EXPECT_EQ(functions.size(), 1u);
  // which is all but the bare tent: without the saving, and without the links that it saves, the grid is the same
  EXPECT_TRUE(fileBytes(bakeHouse(one, exactOptions(), {.free_space = false}).grid) ==
              fileBytes(bakeHouse(one, exactOptions()).grid));
}

TEST(BakeSavings, WithoutThemEveryProbeHasAFunctionOfItsOwn) {
  const std::vector<Generator> one = generators({"tent_mlp"});
  BakeSavings none;
  none.free_space = none.in_solid = none.empty = none.duplicates = none.bare_tent = false;
  const Bake bake = bakeHouse(one, houseOptions(), none);
  EXPECT_EQ(bake.grid.functionCount(), bake.grid.probe_function.size());
  std::vector<uint32_t> numbers = bake.grid.probe_function;
  std::sort(numbers.begin(), numbers.end());
  for (size_t p = 0; p < numbers.size(); ++p) ASSERT_EQ(numbers[p], p);
}

TEST(BakeSavings, DuplicatesTakeAThetaEach) {
  const std::vector<Generator> one = generators({"tent_mlp"});
  const Bake with = bakeHouse(one, houseOptions()), without = bakeHouse(one, houseOptions(), {.duplicates = false});
  const uint64_t duplicates = with.statistics.counts.duplicates;
  ASSERT_GT(duplicates, 0u);
  EXPECT_EQ(without.grid.functionCount(), with.grid.functionCount() + duplicates);
  // what the table says without measuring: D floats and a byte a function
  std::vector<Need> needs = countNeeds(with, one, ThetaPrecision::float32, {1000});
  const auto theta_bytes = static_cast<int64_t>(4 * (without.grid.theta.size() - with.grid.theta.size()));
  EXPECT_EQ(findNeed(needs, need::kDuplicates)->bytes_saved, theta_bytes + static_cast<int64_t>(duplicates));
}

TEST(BakeSavings, LargerGeneratorsWhereTheSmallestIsEnoughChangeNoByte) {
  const std::vector<Generator> both = generators({"tent_mlp4", "tent_mlp"});
  BakeOptions options = houseOptions();
  // enough for about half of the functions; the larger representation for all others, however little it is better
  options.choice.flat_ratio = 1e-6;
  options.choice.enough_rmse = medianRmse(generators({"tent_mlp4"}), options) / options.choice.generator_excess;
  options.correction.correct_rmse = 1e3;
  options.refinement.check = {1e3, 1e3, 1.0};
  const Bake with = bakeHouse(both, options), without = bakeHouse(both, options, {.larger_generators = false});
  EXPECT_GT(with.statistics.smallest_enough, 0u);
  EXPECT_LT(with.statistics.smallest_enough, with.statistics.counts.functions);
  EXPECT_EQ(with.statistics.smallest_enough, without.statistics.smallest_enough);
  EXPECT_EQ(with.statistics.chosen[1], with.statistics.counts.functions - with.statistics.smallest_enough);
  EXPECT_EQ(without.statistics.checked, 2 * with.statistics.counts.functions);
  EXPECT_EQ(with.statistics.checked, without.statistics.checked - with.statistics.smallest_enough);
  EXPECT_TRUE(fileBytes(with.grid) == fileBytes(without.grid));
}

TEST(BakeSavings, RefiningWhatPassesTheCheckOnlyLowersErrors) {
  const std::vector<Generator> one = generators({"tent_mlp"});
  BakeOptions options = houseOptions();
  options.refinement.check = {1e3, 1e3, 1.0};  // everything passes
  options.refinement.rounds = 1;
  const Bake with = bakeHouse(one, options), without = bakeHouse(one, options, {.refinement = false});
  EXPECT_EQ(with.statistics.refined, 0u);
  uint64_t better = 0;
  for (size_t f = 0; f < with.grid.functionCount(); ++f) {
    EXPECT_LE(without.statistics.stored[f].rmse, with.statistics.stored[f].rmse) << "function " << f;
    better += without.statistics.stored[f].rmse < with.statistics.stored[f].rmse;
  }
  EXPECT_GT(better, 0u);
}

TEST(BakeSavings, WhatIsRightIsCorrectedOnlyWithoutTheSaving) {
  const std::vector<Generator> one = generators({"tent_mlp"});
  BakeOptions options = houseOptions();
  options.correction.correct_rmse = 1e3;
  options.refinement.check = {1e3, 1e3, 1.0};
  const Bake with = bakeHouse(one, options), without = bakeHouse(one, options, {.correction = false});
  EXPECT_EQ(with.statistics.right, with.statistics.counts.functions);
  EXPECT_EQ(with.statistics.corrected, 0u);
  EXPECT_EQ(without.statistics.right, with.statistics.right);
  EXPECT_GT(without.statistics.corrected, 0u);
}

TEST(BakeSavings, WhatIsAllButTheBareTentHasNoThetaAndIsNoFurtherOff) {
  const std::vector<Generator> one = generators({"tent_mlp"});
  BakeOptions options = exactOptions();
  options.bare_tent_rmse = 0.004;
  const Bake with = bakeHouse(one, options), without = bakeHouse(one, options, {.bare_tent = false});
  const BareTents& tents = with.statistics.bare_tents;
  ASSERT_GT(tents.count, 0u);
  EXPECT_LE(tents.rmse_sum, options.bare_tent_rmse * static_cast<double>(tents.count));
  EXPECT_GT(tents.rmse_sum, 0.0);
  EXPECT_EQ(without.statistics.bare_tents.count, 0u);
  EXPECT_EQ(probesOf(with.grid, kFreeSpace), probesOf(without.grid, kFreeSpace) + tents.count);
  // in nothing else do the two bakes differ
  for (size_t p = 0; p < with.grid.probe_function.size(); ++p) {
    const uint32_t a = with.grid.probe_function[p], b = without.grid.probe_function[p];
    if (a >= with.grid.functionCount()) {
      EXPECT_TRUE(a == b || (a == kFreeSpace && b < without.grid.functionCount())) << "probe " << p;
      continue;
    }
    EXPECT_EQ(with.statistics.stored[a].rmse, without.statistics.stored[b].rmse) << "probe " << p;
  }
  options.bare_tent_rmse = 0.0;
  EXPECT_TRUE(fileBytes(bakeHouse(one, options).grid) == fileBytes(without.grid));
}

TEST(BakeSavings, BareTentsThatPassTheCheckCouldCountAsFreeSpace) {
  const std::vector<Generator> one = generators({"tent_mlp"});
  const Bake now = bakeHouse(one, exactOptions()), then = bakeHouse(one, exactOptions(), {.passing_tent = true});
  const auto passing = [](const Bake& bake) {
    return std::count(bake.statistics.tent_passes.begin(), bake.statistics.tent_passes.end(), 1);
  };
  ASSERT_GT(passing(now), 0);
  EXPECT_EQ(passing(then), 0);
  EXPECT_EQ(then.grid.functionCount() + static_cast<size_t>(passing(now)), now.grid.functionCount());
  EXPECT_GT(probesOf(then.grid, kFreeSpace), probesOf(now.grid, kFreeSpace));
}

bool everywhere(const PositionM&) { return true; }

TEST(LookUpDifference, SeesEveryProbeThatChanged) {
  const LightGrid grid = bakeHouse(generators({"tent_mlp"}), houseOptions()).grid;
  const std::vector<PositionM> places = lookUpPlaces(grid.tree, 2000, 5, everywhere);
  const LookUpDifference same = lookUpDifference(grid, grid, places);
  EXPECT_EQ(same.changed, 0u);
  EXPECT_EQ(same.largest, 0.0);
  EXPECT_GT(same.look_ups, 1990u);
  // without any weight the difference is the weight itself, whichever of the two has it
  LightGrid bare = grid, none = grid;
  std::fill(bare.probe_function.begin(), bare.probe_function.end(), kFreeSpace);
  std::fill(none.probe_function.begin(), none.probe_function.end(), kNoWeight);
  const LookUpDifference there = lookUpDifference(bare, none, places), back = lookUpDifference(none, bare, places);
  EXPECT_EQ(there.changed, there.look_ups);
  EXPECT_EQ(there.largest, back.largest);
  EXPECT_EQ(there.mean, back.mean);
  // of 8 tents that sum to 1 the largest is at least an eighth
  EXPECT_GE(there.mean, 0.125);
  EXPECT_LE(there.largest, 1.0);
}

TEST(LookUpPlaces, AreThoseOfTheDrawsThatLieInAir) {
  const ProbeTree& tree = house().tree;
  const std::vector<PositionM> all = lookUpPlaces(tree, 500, 5, everywhere);
  ASSERT_EQ(all.size(), 500u);
  const auto low = [&](const PositionM& place) { return place[2] < all[0][2]; };
  std::vector<PositionM> expected;
  std::copy_if(all.begin(), all.end(), std::back_inserter(expected), low);
  EXPECT_EQ(lookUpPlaces(tree, 500, 5, low), expected);
  EXPECT_TRUE(lookUpPlaces(tree, 500, 5, [](const PositionM&) { return false; }).empty());
  EXPECT_NE(lookUpPlaces(tree, 500, 6, everywhere), all);
}

TEST(NeedsMeasurement, EveryLineThatCanBeTurnedHasFiguresAndSaysWhatChanged) {
  const std::vector<Generator> both = generators({"tent_mlp4", "tent_mlp"});
  BakeOptions options = houseOptions();
  options.choice.enough_rmse = 1e3;  // of the larger one nothing is needed
  options.refinement.check = {1e3, 1e3, 1.0};
  options.refinement.rounds = 1;
  const Bake bake = bakeHouse(both, options);
  std::vector<Need> needs = countNeeds(bake, both, ThetaPrecision::float32, {1000, 2000});
  // the house a kilometre from the world's origin: places in it are told from solid all the same
  BakeScene scene("house:3", houseOptions());
  scene.source.scene.origin_m = {1024.0, -512.0, 0.0};
  measureNeeds({scene, both, options, ThetaPrecision::float32, spoolFolder()}, bake.statistics, 2, &needs);
  const SupportVisibility visibility(scene.rays, scene.links);
  uint64_t in_air = 0;
  for (const PositionM& place : lookUpPlaces(scene.tree, 20000, 1, everywhere)) {
    const SolidVote vote = visibility.voteAt({place[0], place[1], place[2]});
    in_air += !vote.solid() && !vote.disputed();
  }
  EXPECT_GT(in_air, 0u);
  EXPECT_LT(in_air, 20000u) << "no solid: nothing is left out of the comparison";
  const std::set<std::string> only_counted = {need::kNeverChosen, need::kLevels,   need::kThroughLevels,
                                              need::kEmptyRoots,  need::kLighting, need::kSolidRays};
  for (const Need& need : needs) {
    if (need.count == 0 || only_counted.contains(need.what)) continue;
    EXPECT_TRUE(need.seconds_saved) << need.what;
    ASSERT_TRUE(need.seconds_noise) << need.what;
    EXPECT_GE(*need.seconds_noise, 0.0) << need.what;
    const std::vector<double> numbers = numbersIn(need.note);
    const auto says = [&](double number) { return std::find(numbers.begin(), numbers.end(), number) != numbers.end(); };
    EXPECT_TRUE(says(static_cast<double>(in_air))) << need.what << ", " << in_air << " places: " << need.note;
    EXPECT_TRUE(says(2)) << need.what << ", 2 rounds: " << need.note;
    EXPECT_TRUE(need.bytes_saved) << need.what;
    ASSERT_TRUE(need.same_result) << need.what;
  }
  const auto line = [&](const char* what) { return *findNeed(needs, what); };
  EXPECT_EQ(line(need::kLargerGenerators).count, bake.statistics.counts.functions);
  EXPECT_EQ(line(need::kLargerGenerators).same_result, true);
  EXPECT_EQ(line(need::kLargerGenerators).bytes_saved, 0);
  EXPECT_EQ(line(need::kNeverChosen).bytes_saved, 2000);
  EXPECT_EQ(line(need::kNeverChosenGenerators).same_result, true) << "its generator never ran";
  EXPECT_EQ(line(need::kHalfTheta).same_result, false);
  EXPECT_NEAR(static_cast<double>(*line(need::kHalfTheta).bytes_saved), 2.0 * static_cast<double>(bake.grid.theta.size()), 128.0)
      << "the file's fillers are at most 64 bytes a tensor";
  EXPECT_GT(*line(need::kAllProbes).bytes_saved, *line(need::kDuplicates).bytes_saved);
  EXPECT_TRUE(line(need::kSolidRays).seconds_saved);
  EXPECT_TRUE(line(need::kSolidRays).seconds_noise);
}

}  // namespace
}  // namespace nlg
