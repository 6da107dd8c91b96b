// What a scene does not need: the counts of the lines add up.

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "bake/savings.h"
#include "tests/bake/house_corner.h"
#include "tests/runtime_eval/sample_generator.h"

namespace nlg {
namespace {

// Duplicates are the same bytes: whether two functions share a theta does not depend on what else is left out.
BakeOptions exactOptions() {
  BakeOptions options = houseCornerOptions();
  options.duplicate_rms = 0.0;
  options.duplicate_validity_points = 0;
  return options;
}

const BakeScene& house() {
  static const BakeScene scene("house:3", houseCornerOptions());
  return scene;
}

Bake bakeHouse(const std::vector<Generator>& generators, const BakeOptions& options) {
  return bakeOf(house(), options, {}, generators);
}

uint64_t probesOf(const LightGrid& grid, uint32_t function) {
  return static_cast<uint64_t>(std::count(grid.probe_function.begin(), grid.probe_function.end(), function));
}

// The median error of what generators make, nothing corrected.
double medianRmse(const std::vector<Generator>& generators, BakeOptions options) {
  options.policy.good_rmse = 1e3;
  options.policy.check() = {1e3, 1e3, 1.0, 1.0, 1.0};
  std::vector<double> rmse;
  for (const ThetaRecord& record : bakeHouse(generators, options).statistics.records)
    rmse.push_back(record.at(ThetaWord::stored).rmse);
  std::sort(rmse.begin(), rmse.end());
  return rmse[rmse.size() / 2];
}

// The table of a bake on two threads that stores float32, and a line of it.
std::vector<Saving> savingsOf(const Bake& bake, const std::vector<Generator>& generators, const BakeOptions& options) {
  const std::vector<uint64_t> weights_bytes = {1000, 2000};
  return savingsOf(bake, generators, options.policy, {ThetaPrecision::float32}, weights_bytes, options.threads);
}

const Saving& lineOf(const std::vector<Saving>& savings, const std::string& what) {
  const auto found = std::find_if(savings.begin(), savings.end(), [&](const Saving& saving) { return saving.what == what; });
  if (found == savings.end()) throw std::out_of_range("no line: " + what);
  return *found;
}

TEST(Savings, CountsAreThoseOfTheBakeAndAddUp) {
  const std::vector<Generator> both = sampleGenerators({"tent_mlp", "mlp"});
  const Bake bake = bakeHouse(both, houseCornerOptions());
  const std::vector<Saving> savings = savingsOf(bake, both, houseCornerOptions());
  const ShardCounts& counts = bake.statistics.counts;
  const auto count = [&](const char* what) { return lineOf(savings, what).count; };
  const uint64_t free_space = count("probes in free space"), tents = count("functions that are all but the bare tent"),
                 duplicates = count("duplicates"), in_solid = count("probes in solid"),
                 empty = count("probes whose function is 0 everywhere");
  EXPECT_GT(free_space, 0u);
  EXPECT_GT(duplicates, 0u);
  EXPECT_GT(tents, 0u);
  EXPECT_EQ(free_space + tents, probesOf(bake.grid, kFreeSpace));
  EXPECT_EQ(in_solid + empty, probesOf(bake.grid, kNoWeight));
  EXPECT_EQ(free_space + tents + duplicates + in_solid + empty + counts.functions, counts.grid_probes);
  EXPECT_EQ(count("theta of the largest representation") + bake.statistics.chosen(2).back(), counts.functions);
  // nothing is refined here: what passes the check needs no refinement, what fails it has had none
  EXPECT_EQ(bake.statistics.refined(), 0u);
  EXPECT_EQ(count("refinements") + bake.statistics.failing(ThetaWord::fitted, houseCornerOptions().policy.check()),
            counts.functions);
  EXPECT_FALSE(lineOf(savings, "refinements").seconds) << "none was made: nobody knows what one takes";
  int64_t never_bytes = 0;
  for (size_t g = 0; g < both.size(); ++g)
    never_bytes += bake.statistics.chosen(2)[g] == 0 ? 1000 * (static_cast<int64_t>(g) + 1) : 0;
  EXPECT_EQ(lineOf(savings, "representations never chosen").bytes, never_bytes);
  std::set<std::string> names;
  for (const Saving& saving : savings) {
    EXPECT_LE(saving.count, saving.of) << saving.what;
    EXPECT_FALSE(saving.note.empty()) << saving.what;
    EXPECT_TRUE(names.insert(saving.what).second) << saving.what << " stands there twice";
  }
}

TEST(Savings, LargerGeneratorsRunOnlyWhereTheSmallestIsNotEnough) {
  const std::vector<Generator> both = sampleGenerators({"tent_mlp4", "tent_mlp"});
  BakeOptions options = houseCornerOptions();
  // enough for about half of the functions; the larger representation for all others, however little it is better
  options.policy.choice_flat_ratio = 1e-6;
  options.policy.choice_enough_rmse =
      medianRmse(sampleGenerators({"tent_mlp4"}), options) / options.policy.choice_generator_excess;
  options.policy.good_rmse = 1e3;
  options.policy.check() = {1e3, 1e3, 1.0, 1.0, 1.0};
  const Bake house = bakeHouse(both, options);
  const auto& larger_ran = house.statistics.larger_ran;
  const auto larger = static_cast<uint64_t>(std::count(larger_ran.begin(), larger_ran.end(), 1));
  EXPECT_GT(larger, 0u);
  EXPECT_LT(larger, house.statistics.counts.functions);
  EXPECT_EQ(house.statistics.chosen(2)[1], larger);
  EXPECT_EQ(lineOf(savingsOf(house, both, options), "functions that the smallest representation already fits").count,
            house.statistics.counts.functions - larger);
}

TEST(Savings, WhatIsGoodTakesNoStageAfterTheNetwork) {
  const std::vector<Generator> one = sampleGenerators({"tent_mlp"});
  BakeOptions options = houseCornerOptions();
  options.policy.good_rmse = 1e3;
  options.policy.check() = {1e3, 1e3, 1.0, 1.0, 1.0};
  const Bake good = bakeHouse(one, options);
  const char* line = "corrections and fits of thetas that are good";
  EXPECT_EQ(lineOf(savingsOf(good, one, options), line).count, good.statistics.counts.functions);
  for (const ThetaRecord& record : good.statistics.records) EXPECT_EQ(record.ended, ThetaStage::network);
  options.policy.good_rmse = 0.0;
  const Bake all = bakeHouse(one, options);
  EXPECT_EQ(lineOf(savingsOf(all, one, options), line).count, 0u);
  uint64_t better = 0;
  for (size_t f = 0; f < all.statistics.records.size(); ++f) {
    const ThetaRecord &record = all.statistics.records[f], &before = good.statistics.records[f];
    EXPECT_LE(record.at(ThetaWord::stored).rmse, before.at(ThetaWord::stored).rmse * (1.0 + 1e-6)) << "function " << f;
    better += record.at(ThetaWord::stored).rmse < before.at(ThetaWord::stored).rmse;
  }
  EXPECT_GT(better, 0u);
}

TEST(Savings, WhatIsAllButTheBareTentHasNoThetaAndIsNoFurtherOff) {
  const std::vector<Generator> one = sampleGenerators({"tent_mlp"});
  BakeOptions options = exactOptions();
  options.policy.bare_tent_rmse = 0.004;
  const Bake with = bakeHouse(one, options);
  BakeOptions none = options;
  none.policy.bare_tent_rmse = 0.0;
  const Bake without = bakeHouse(one, none);
  const TentCounts& tents = with.statistics.bare_tents;
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

}  // namespace
}  // namespace nlg
