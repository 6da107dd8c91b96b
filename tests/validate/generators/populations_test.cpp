#include "validate/generators/populations.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace nlg {
namespace {

// Functions of three scenes, one after another.
std::vector<uint32_t> scenes(const std::vector<int>& counts) {
  std::vector<uint32_t> scene_idx;
  for (size_t s = 0; s < counts.size(); ++s) scene_idx.insert(scene_idx.end(), counts[s], static_cast<uint32_t>(s));
  return scene_idx;
}

std::vector<int> countsOf(const std::vector<uint64_t>& chosen, const std::vector<uint32_t>& scene_idx, size_t scene_count) {
  std::vector<int> counts(scene_count, 0);
  for (const uint64_t function : chosen) ++counts[scene_idx[function]];
  return counts;
}

TEST(ChooseEvenly, TakesAsManyOfEveryScene) {
  const std::vector<uint32_t> scene_idx = scenes({1000, 50, 10});
  EXPECT_EQ(countsOf(chooseEvenly(scene_idx, 3, 30), scene_idx, 3), (std::vector<int>{10, 10, 10}));
}

TEST(ChooseEvenly, TakesMoreOfOthersWhereASceneHasNoMore) {
  const std::vector<uint32_t> scene_idx = scenes({1000, 50, 3});
  EXPECT_EQ(countsOf(chooseEvenly(scene_idx, 3, 30), scene_idx, 3), (std::vector<int>{14, 13, 3}));
  EXPECT_EQ(countsOf(chooseEvenly(scene_idx, 3, 5000), scene_idx, 3), (std::vector<int>{1000, 50, 3}));
}

TEST(ChooseEvenly, TakesNoFunctionTwiceAndSpreadsThemOverTheScene) {
  const std::vector<uint32_t> scene_idx = scenes({1000, 50, 10});
  const std::vector<uint64_t> chosen = chooseEvenly(scene_idx, 3, 45);
  EXPECT_EQ(std::set<uint64_t>(chosen.begin(), chosen.end()).size(), 45u);
  uint64_t last_of_first = 0;
  for (const uint64_t function : chosen) {
    if (function < 1000) last_of_first = std::max(last_of_first, function);
  }
  EXPECT_GE(last_of_first, 900u) << "18 of 1000 at equal distances reach the last tenth";
}

TEST(ChooseEvenly, HasAllScenesInEveryStretch) {
  const std::vector<uint32_t> scene_idx = scenes({100, 100, 100});
  const std::vector<uint64_t> chosen = chooseEvenly(scene_idx, 3, 60);
  for (size_t begin = 0; begin < 60; begin += 3) {
    const std::set<uint32_t> met = {scene_idx[chosen[begin]], scene_idx[chosen[begin + 1]], scene_idx[chosen[begin + 2]]};
    EXPECT_EQ(met.size(), 3u) << "from " << begin;
  }
}

}  // namespace
}  // namespace nlg
