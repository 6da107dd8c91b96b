#include "validate/frontier/front.h"

#include <gtest/gtest.h>

namespace nlg {
namespace {

// Three scenes of two functions.
const std::vector<uint32_t> kScene = {0, 0, 1, 1, 2, 2};

// The same for every function.
TimedPoint even(const std::string& family, const std::string& label, double us, double error, double fails = 0.0) {
  const auto all = [](double value) { return std::vector<double>(kScene.size(), value); };
  return {family, label, all(us), all(error), all(fails)};
}

EqualError compare(const TimedPoint& own, const std::vector<TimedPoint>& baselines) {
  return compareAtEqualError(own, baselines, SceneBootstrap(kScene));
}

TEST(EqualError, LiesOnALineInLogarithmsBetweenTwoBudgets) {
  // error falls as 1 / sqrt(time), so that it is .01 after 400 µs
  const EqualError equal = compare(even("", "own", 10, 0.01), {even("lm", "short", 100, 0.02), even("lm", "long", 10000, 0.002)});
  EXPECT_NEAR(equal.baseline_us, 400, 1e-9 * 400);
  EXPECT_EQ(equal.baseline, "between short and long");
  ASSERT_TRUE(equal.ratio);
  EXPECT_NEAR(equal.ratio->value, 40, 1e-9 * 40);
  // all scenes alike: no draw moves it
  EXPECT_NEAR(equal.ratio->low, 40, 1e-9 * 40);
  ASSERT_TRUE(equal.ratio->high);
  EXPECT_NEAR(*equal.ratio->high, 40, 1e-9 * 40);
}

TEST(EqualError, TakesTheFastestFamily) {
  const EqualError equal =
      compare(even("", "own", 10, 0.01), {even("lm", "lm 1", 100, 0.02), even("lm", "lm 2", 10000, 0.002),
                                          even("adam", "adam 1", 50, 0.02), even("adam", "adam 2", 200, 0.01)});
  EXPECT_NEAR(equal.baseline_us, 200, 1e-9 * 200);
  EXPECT_NE(equal.baseline.find("adam 2"), std::string::npos) << equal.baseline;
}

TEST(EqualError, PassesOverBudgetsThatAnotherOfTheirFamilyBeats) {
  // the middle one is slower and worse than the first: were it on the line, 500 µs would be the answer
  const EqualError equal =
      compare(even("", "own", 10, 0.01), {even("lm", "1", 100, 0.02), even("lm", "2", 500, 0.03), even("lm", "4", 10000, 0.002)});
  EXPECT_NEAR(equal.baseline_us, 400, 1e-9 * 400);
  EXPECT_EQ(equal.baseline, "between 1 and 4");
}

TEST(EqualError, HasAnIntervalOverScenesThatHoldsItsValue) {
  TimedPoint own = even("", "own", 10, 0.01), first = even("lm", "1", 100, 0.02), second = even("lm", "2", 10000, 0.002);
  for (size_t i = 0; i < kScene.size(); ++i) {
    first.us[i] *= 1 + kScene[i];
    second.us[i] *= 1 + kScene[i];
  }
  const EqualError equal = compare(own, {first, second});
  ASSERT_TRUE(equal.ratio && equal.ratio->high);
  // scenes at ratios of 40, 80 and 120: draws of one scene three times are 1 in 27 each, more than the tails hold
  EXPECT_NEAR(equal.ratio->value, 80, 1e-9 * 80);
  EXPECT_NEAR(equal.ratio->low, 40, 1e-9 * 40);
  EXPECT_NEAR(*equal.ratio->high, 120, 1e-9 * 120);
}

TEST(EqualError, SaysHowManyFailOnBothSides) {
  TimedPoint own = even("", "own", 10, 0.01), first = even("lm", "1", 100, 0.02, 1.0), second = even("lm", "2", 10000, 0.005);
  own.fails_check[0] = own.fails_check[1] = 1.0;  // both functions of one scene of three
  const EqualError equal = compare(own, {first, second});
  ASSERT_TRUE(equal.ratio);
  EXPECT_NEAR(equal.share_failing.value, 1.0 / 3.0, 1e-12);
  EXPECT_EQ(equal.share_failing.low, 0.0);
  EXPECT_EQ(equal.share_failing.high, 1.0);
  // half of the way, in logarithms, from all that fail to none
  EXPECT_NEAR(equal.baseline_share_failing.value, 0.5, 1e-9);
  EXPECT_NEAR(equal.baseline_share_failing.high, 0.5, 1e-9) << "all scenes alike";
}

TEST(EqualError, HasNoUpperBoundWhenManyDrawsNeverReachIt) {
  TimedPoint own = even("", "own", 10, 0.01), fit = even("lm", "2", 10000, 0.002);
  // in one scene of three fits stay far above; a draw of that scene alone never reaches the error
  for (size_t i = 0; i < kScene.size(); ++i) {
    if (kScene[i] == 2) fit.blend_rmse[i] = 0.02;
  }
  const EqualError equal = compare(own, {even("lm", "1", 100, 0.03), fit});
  ASSERT_TRUE(equal.ratio);
  EXPECT_FALSE(equal.ratio->high);
}

}  // namespace
}  // namespace nlg
