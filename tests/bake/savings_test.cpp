// What a scene does not need: the lines' counts add up, and what they claim to be saved is what a bake without the saving takes.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <set>

#include "bake/look_up_difference.h"
#include "bake/savings_measurement.h"
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
  options.policy.refinement.rounds = 0;
  options.policy.refinement.first_steps = 4;
  options.policy.stages.adam_steps = 20;
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

Bake bakeHouse(const std::vector<Generator>& generators, const BakeOptions& options, const LeftOut& left_out = {}) {
  return bakeScene(house(), generators, options, spoolFolder(), left_out);
}

std::string fileBytes(const LightGrid& grid) {
  std::string bytes;
  const FileResult result = serializeLightGrid(grid, {ThetaPrecision::float32}, {}, &bytes);
  EXPECT_TRUE(result.ok()) << result.detail;
  return bytes;
}

uint64_t probesOf(const LightGrid& grid, uint32_t function) {
  return static_cast<uint64_t>(std::count(grid.probe_function.begin(), grid.probe_function.end(), function));
}

// The median error of what generators make, nothing corrected.
double medianRmse(const std::vector<Generator>& generators, BakeOptions options) {
  options.policy.stages.good_rmse = 1e3;
  options.policy.refinement.check = {1e3, 1e3, 1.0};
  std::vector<double> rmse;
  for (const ThetaRecord& record : bakeHouse(generators, options).statistics.records)
    rmse.push_back(record.at(ThetaWord::stored).rmse);
  std::sort(rmse.begin(), rmse.end());
  return rmse[rmse.size() / 2];
}

TEST(Savings, CountsAreThoseOfTheBakeAndAddUp) {
  const std::vector<Generator> both = generators({"tent_mlp", "mlp"});
  const Bake bake = bakeHouse(both, houseOptions());
  std::vector<Saving> savings = countSavings(bake, both, houseOptions().policy, {1000, 2000});
  const ShardCounts& counts = bake.statistics.counts;
  const auto line = [&](const char* what) -> const Saving& {
    Saving* saving = findSaving(savings, what);
    EXPECT_NE(saving, nullptr) << what;
    return *saving;
  };
  EXPECT_GT(line(saving::kFreeSpace).count, 0u);
  EXPECT_GT(line(saving::kDuplicates).count, 0u);
  EXPECT_GT(line(saving::kBareTent).count, 0u);
  EXPECT_EQ(line(saving::kFreeSpace).count + line(saving::kBareTent).count, probesOf(bake.grid, kFreeSpace));
  EXPECT_EQ(line(saving::kInSolid).count + line(saving::kEmpty).count, probesOf(bake.grid, kNoWeight));
  const uint64_t parts = line(saving::kFreeSpace).count + line(saving::kInSolid).count + line(saving::kEmpty).count +
                         line(saving::kDuplicates).count + line(saving::kBareTent).count;
  EXPECT_EQ(line(saving::kAllProbes).count, parts);
  EXPECT_EQ(parts + counts.functions, counts.grid_probes);
  EXPECT_EQ(line(saving::kLargestTheta).count + bake.statistics.chosen(2).back(), counts.functions);
  // nothing is refined here: what passes the check needs no refinement, what fails it has had none
  EXPECT_EQ(bake.statistics.refined(), 0u);
  EXPECT_EQ(line(saving::kRefinement).count + bake.statistics.failing(ThetaWord::fitted, houseOptions().policy.check()),
            counts.functions);
  uint64_t never_bytes = 0;
  for (size_t g = 0; g < both.size(); ++g) never_bytes += bake.statistics.chosen(2)[g] == 0 ? 1000 * (g + 1) : 0;
  EXPECT_EQ(line(saving::kNeverChosen).bytes_saved, static_cast<int64_t>(never_bytes));
  for (const Saving& saving : savings) {
    EXPECT_LE(saving.count, saving.of) << saving.what;
    EXPECT_FALSE(saving.seconds_saved) << saving.what << ": nothing was measured";
    EXPECT_FALSE(saving.same_result) << saving.what << ": nothing was compared";
    EXPECT_FALSE(saving.note.empty()) << saving.what;
  }
}

TEST(Savings, TablesHaveEveryLineAndTheKeysOfTheReport) {
  const std::vector<Generator> one = generators({"tent_mlp"});
  const std::vector<Saving> savings = countSavings(bakeHouse(one, houseOptions()), one, houseOptions().policy, {1000});
  const nlohmann::ordered_json json = toJson(savings);
  const std::string text = toTable(savings);
  ASSERT_EQ(json.size(), savings.size());
  std::set<std::string> names;
  for (size_t i = 0; i < savings.size(); ++i) {
    for (const char* key :
         {"what", "left_out", "count", "of", "seconds_saved", "seconds_noise", "bytes_saved", "same_result", "note"}) {
      EXPECT_TRUE(json[i].contains(key)) << savings[i].what << ": " << key;
    }
    EXPECT_NE(text.find(savings[i].what), std::string::npos) << text;
    EXPECT_TRUE(names.insert(savings[i].what).second) << savings[i].what << " stands there twice";
  }
  EXPECT_EQ(json.back().at("what"), saving::kLightBits);
}

TEST(LeftOut, FreeSpaceIsOneFunctionForAllOfIt) {
  const std::vector<Generator> one = generators({"tent_mlp"});
  BakeOptions options = exactOptions();
  options.policy.bare_tent_rmse = 0.0;
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

TEST(LeftOut, WithoutThemEveryProbeHasAFunctionOfItsOwn) {
  const std::vector<Generator> one = generators({"tent_mlp"});
  BakeOptions options = houseOptions();
  options.policy.bare_tent_rmse = 0.0;
  const Bake bake = bakeHouse(one, options, {false, false, false, false});
  EXPECT_EQ(bake.grid.functionCount(), bake.grid.probe_function.size());
  std::vector<uint32_t> numbers = bake.grid.probe_function;
  std::sort(numbers.begin(), numbers.end());
  for (size_t p = 0; p < numbers.size(); ++p) ASSERT_EQ(numbers[p], p);
}

TEST(LeftOut, DuplicatesTakeAThetaEach) {
  const std::vector<Generator> one = generators({"tent_mlp"});
  const Bake with = bakeHouse(one, houseOptions()), without = bakeHouse(one, houseOptions(), {.duplicates = false});
  const uint64_t duplicates = with.statistics.counts.duplicates;
  ASSERT_GT(duplicates, 0u);
  EXPECT_EQ(without.grid.functionCount(), with.grid.functionCount() + duplicates);
  // what the table says without measuring: D floats and a byte a function
  std::vector<Saving> savings = countSavings(with, one, houseOptions().policy, {1000});
  const auto theta_bytes = static_cast<int64_t>(4 * (without.grid.theta.size() - with.grid.theta.size()));
  EXPECT_EQ(findSaving(savings, saving::kDuplicates)->bytes_saved, theta_bytes + static_cast<int64_t>(duplicates));
}

TEST(Savings, LargerGeneratorsRunOnlyWhereTheSmallestIsNotEnough) {
  const std::vector<Generator> both = generators({"tent_mlp4", "tent_mlp"});
  BakeOptions options = houseOptions();
  // enough for about half of the functions; the larger representation for all others, however little it is better
  options.policy.choice.flat_ratio = 1e-6;
  options.policy.choice.enough_rmse = medianRmse(generators({"tent_mlp4"}), options) / options.policy.choice.generator_excess;
  options.policy.stages.good_rmse = 1e3;
  options.policy.refinement.check = {1e3, 1e3, 1.0};
  const Bake house = bakeHouse(both, options);
  const auto& larger_ran = house.statistics.larger_ran;
  const auto larger = static_cast<uint64_t>(std::count(larger_ran.begin(), larger_ran.end(), 1));
  EXPECT_GT(larger, 0u);
  EXPECT_LT(larger, house.statistics.counts.functions);
  EXPECT_EQ(house.statistics.chosen(2)[1], larger);
  std::vector<Saving> savings = countSavings(house, both, options.policy, {1000, 2000});
  EXPECT_EQ(findSaving(savings, saving::kLargerGenerators)->count, house.statistics.counts.functions - larger);
}

TEST(Savings, WhatIsGoodTakesNoStageAfterTheNetwork) {
  const std::vector<Generator> one = generators({"tent_mlp"});
  BakeOptions options = houseOptions();
  options.policy.stages.good_rmse = 1e3;
  options.policy.refinement.check = {1e3, 1e3, 1.0};
  const Bake good = bakeHouse(one, options);
  std::vector<Saving> savings = countSavings(good, one, options.policy, {1000});
  EXPECT_EQ(findSaving(savings, saving::kGoodTheta)->count, good.statistics.counts.functions);
  for (const ThetaRecord& record : good.statistics.records) EXPECT_EQ(record.ended, ThetaStage::network);
  options.policy.stages.good_rmse = 0.0;
  const Bake all = bakeHouse(one, options);
  savings = countSavings(all, one, options.policy, {1000});
  EXPECT_EQ(findSaving(savings, saving::kGoodTheta)->count, 0u);
  uint64_t better = 0;
  for (size_t f = 0; f < all.statistics.records.size(); ++f) {
    const ThetaRecord &record = all.statistics.records[f], &before = good.statistics.records[f];
    EXPECT_LE(record.at(ThetaWord::stored).rmse, before.at(ThetaWord::stored).rmse * (1.0 + 1e-6)) << "function " << f;
    better += record.at(ThetaWord::stored).rmse < before.at(ThetaWord::stored).rmse;
  }
  EXPECT_GT(better, 0u);
}

TEST(LeftOut, WhatIsAllButTheBareTentHasNoThetaAndIsNoFurtherOff) {
  const std::vector<Generator> one = generators({"tent_mlp"});
  BakeOptions options = exactOptions();
  options.policy.bare_tent_rmse = 0.004;
  const Bake with = bakeHouse(one, options);
  BakeOptions none = options;
  none.policy.bare_tent_rmse = 0.0;
  const Bake without = bakeHouse(one, none);
  const BareTents& tents = with.statistics.bare_tents;
  ASSERT_GT(tents.count, 0u);
  EXPECT_LE(tents.rmse_sum, options.policy.bare_tent_rmse * static_cast<double>(tents.count));
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
    EXPECT_EQ(with.statistics.records[a].at(ThetaWord::stored).rmse, without.statistics.records[b].at(ThetaWord::stored).rmse)
        << "probe " << p;
  }
}

TEST(LeftOut, BareTentsThatPassTheCheckCouldCountAsFreeSpace) {
  const std::vector<Generator> one = generators({"tent_mlp"});
  BakeOptions passing_tents = exactOptions();
  passing_tents.policy.bare_tent_rmse = passing_tents.policy.check().tau_rmse;
  const Bake now = bakeHouse(one, exactOptions()), then = bakeHouse(one, passing_tents);
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

TEST(SavingsMeasurement, EveryLineThatCanBeTurnedHasFiguresAndSaysWhatChanged) {
  const std::vector<Generator> both = generators({"tent_mlp4", "tent_mlp"});
  BakeOptions options = houseOptions();
  options.policy.choice.enough_rmse = 1e3;  // of the larger one nothing is needed
  options.policy.refinement.check = {1e3, 1e3, 1.0};
  options.policy.refinement.rounds = 1;
  const Bake bake = bakeHouse(both, options);
  std::vector<Saving> savings = countSavings(bake, both, houseOptions().policy, {1000, 2000});
  // the house a kilometre from the world's origin: places in it are told from solid all the same
  BakeScene scene("house:3", houseOptions());
  scene.source.scene.origin_m = {1024.0, -512.0, 0.0};
  measureSavings({scene, both, options, spoolFolder()}, bake.statistics, 2, &savings);
  const SupportVisibility visibility(scene.rays, scene.links);
  uint64_t in_air = 0;
  for (const PositionM& place : lookUpPlaces(scene.tree, 20000, 1, everywhere)) {
    const SolidVote vote = visibility.voteAt({place[0], place[1], place[2]});
    in_air += !vote.solid() && !vote.disputed();
  }
  EXPECT_GT(in_air, 0u);
  EXPECT_LT(in_air, 20000u) << "no solid: nothing is left out of the comparison";
  const std::set<std::string> only_counted = {saving::kNeverChosen,   saving::kLevels,           saving::kThroughLevels,
                                              saving::kEmptyRoots,    saving::kAirlessCells,     saving::kUnreadProbes,
                                              saving::kStoredBounces, saving::kSharedBounces,    saving::kLightBits,
                                              saving::kSolidRays,     saving::kLargerGenerators, saving::kRefinement};
  for (const Saving& saving : savings) {
    if (saving.count == 0 || only_counted.contains(saving.what)) continue;
    EXPECT_TRUE(saving.seconds_saved) << saving.what;
    ASSERT_TRUE(saving.seconds_noise) << saving.what;
    EXPECT_GE(*saving.seconds_noise, 0.0) << saving.what;
    const std::vector<double> numbers = numbersIn(saving.note);
    const auto says = [&](double number) { return std::find(numbers.begin(), numbers.end(), number) != numbers.end(); };
    EXPECT_TRUE(says(static_cast<double>(in_air))) << saving.what << ", " << in_air << " places: " << saving.note;
    EXPECT_TRUE(says(2)) << saving.what << ", 2 rounds: " << saving.note;
    EXPECT_TRUE(saving.bytes_saved) << saving.what;
    ASSERT_TRUE(saving.same_result) << saving.what;
  }
  const auto line = [&](const char* what) { return *findSaving(savings, what); };
  EXPECT_EQ(line(saving::kLargerGenerators).count, bake.statistics.counts.functions);
  EXPECT_EQ(line(saving::kLargerGenerators).bytes_saved, 0);
  EXPECT_EQ(line(saving::kNeverChosen).bytes_saved, 2000);
  EXPECT_EQ(line(saving::kNeverChosenGenerators).same_result, true) << "its generator never ran";
  EXPECT_EQ(line(saving::kThetaBits).same_result, false);
  EXPECT_NEAR(static_cast<double>(*line(saving::kThetaBits).bytes_saved), 2.0 * static_cast<double>(bake.grid.theta.size()),
              128.0)
      << "the file's fillers are at most 64 bytes a tensor";
  EXPECT_GT(*line(saving::kAllProbes).bytes_saved, *line(saving::kDuplicates).bytes_saved);
  EXPECT_TRUE(line(saving::kSolidRays).seconds_saved);
  EXPECT_TRUE(line(saving::kSolidRays).seconds_noise);
}

}  // namespace
}  // namespace nlg
