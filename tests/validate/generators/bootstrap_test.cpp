#include "validate/generators/statistics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

// Functions of scenes that differ: each value is its scene's level plus its own noise.
struct Sample {
  std::vector<double> values;
  std::vector<uint32_t> scenes;
};
Sample drawScenes(int scene_count, int functions, uint64_t seed) {
  Random random(seed);
  Sample sample;
  for (int s = 0; s < scene_count; ++s) {
    const double level = random.normal();
    for (int i = 0; i < functions; ++i) {
      sample.values.push_back(level + 0.5 * random.normal());
      sample.scenes.push_back(static_cast<uint32_t>(s));
    }
  }
  return sample;
}

struct Coverage {
  double mean = 0.0, median = 0.0, p95 = 0.0;
};

// How often the interval holds the truth: 0 for mean and median, and 1.6449 standard deviations of sqrt(1 + 1/4) for the 95th
// percentile.
Coverage coverage(bool functions_are_scenes) {
  constexpr int kTrials = 400, kScenes = 24, kFunctions = 30;
  const double p95 = 1.6449 * std::sqrt(1.25);
  Coverage holds;
  for (int trial = 0; trial < kTrials; ++trial) {
    Sample sample = drawScenes(kScenes, kFunctions, mixSeed(7, trial));
    if (functions_are_scenes) {
      for (size_t i = 0; i < sample.scenes.size(); ++i) sample.scenes[i] = static_cast<uint32_t>(i);
    }
    BootstrapOptions options;
    options.resamples = 300;
    const SceneBootstrap bootstrap(sample.scenes, options);
    const auto contains = [](const Interval& interval, double truth) {
      return (interval.low <= truth && truth <= interval.high) / static_cast<double>(kTrials);
    };
    holds.mean += contains(bootstrap.mean(sample.values), 0.0);
    const std::vector<Interval> quantiles = bootstrap.quantiles(sample.values, {0.5, 0.95});
    holds.median += contains(quantiles[0], 0.0);
    holds.p95 += contains(quantiles[1], p95);
  }
  return holds;
}

TEST(SceneBootstrap, HoldsTheTruthAboutAsOftenAsItSays) {
  // percentile intervals over 24 scenes: a mean's are too narrow by (24 - 1) / 24 in variance and by the tails of the normal instead
  // of Student's distribution, which takes 95 to about 92.5 %; 400 trials add a standard error of 1.3
  const Coverage holds = coverage(false);
  EXPECT_GE(holds.mean, 0.885);
  EXPECT_LE(holds.mean, 0.985);
  EXPECT_GE(holds.median, 0.885);
  // the 95th percentile hangs on the two or three highest scenes
  EXPECT_GE(holds.p95, 0.75);
}

TEST(SceneBootstrap, DrawsScenesBecauseFunctionsOfOneResembleEachOther) {
  // over functions the interval would be narrower by about sqrt(30 * (1 + .25 / 30) / 1.25), nearly five times
  EXPECT_LT(coverage(true).mean, 0.5);
}

TEST(SceneBootstrap, TakesTheFunctionsOfOneSceneForWhatTheyAre) {
  // the mean of 400 normal numbers of deviation .5 moves by .025: the interval is four times as wide
  const Sample sample = drawScenes(1, 400, 5);
  const SceneBootstrap bootstrap(sample.scenes);
  const Interval mean = bootstrap.mean(sample.values), median = bootstrap.quantiles(sample.values, {0.5}).front();
  EXPECT_NEAR(mean.high - mean.low, 4 * 0.025, 0.02);
  // and their median by sqrt(pi / 2) as much again
  EXPECT_NEAR(median.high - median.low, 4 * 0.025 * 1.2533, 0.04);
}

TEST(SceneBootstrap, ItsQuantilesAreThoseOfAListWrittenOut) {
  // one resample: the interval's ends are its figure, which a list of the values drawn gives as well
  const Sample sample = drawScenes(5, 7, 3);
  BootstrapOptions options;
  options.resamples = 1;
  const SceneBootstrap bootstrap(sample.scenes, options);
  const std::vector<double> shares = {0.0, 0.5, 0.95, 0.99, 1.0};
  const std::vector<Interval> intervals = bootstrap.quantiles(sample.values, shares);
  Random random(options.seed);
  std::vector<double> drawn;
  for (int draw = 0; draw < 5; ++draw) {
    const uint32_t scene = random.below(5);
    for (int i = 0; i < 7; ++i) drawn.push_back(sample.values[7 * scene + random.below(7)]);
  }
  for (size_t q = 0; q < shares.size(); ++q) EXPECT_DOUBLE_EQ(intervals[q].low, quantile(drawn, shares[q])) << shares[q];
  EXPECT_DOUBLE_EQ(bootstrap.mean(sample.values).low, mean(drawn));
}

}  // namespace
}  // namespace nlg
