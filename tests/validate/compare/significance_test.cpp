#include "validate/compare/significance.h"

#include <gtest/gtest.h>

#include <cmath>

namespace nlg {
namespace {

TEST(StudentChance, IsThatOfTheTables) {
  struct Row {
    double t, degrees_of_freedom, chance;
  };
  // quantiles of printed tables, to all of their digits
  const Row rows[] = {{12.7062047362, 1, 0.05}, {2.3646242516, 7, 0.05},  {2.2281388520, 10, 0.05}, {2.0422724563, 30, 0.05},
                      {6.8688266259, 5, 0.001}, {3.4994832974, 7, 0.01},  {1.8124611228, 10, 0.1},  {4.5868938587, 10, 0.001},
                      {63.656741162, 1, 0.01},  {3.6459586355, 30, 0.001}};
  for (const Row& row : rows) {
    EXPECT_NEAR(studentChance(row.t, row.degrees_of_freedom), row.chance, 1e-6 * row.chance) << row.t;
    EXPECT_EQ(studentChance(-row.t, row.degrees_of_freedom), studentChance(row.t, row.degrees_of_freedom));
  }
  EXPECT_EQ(studentChance(0.0, 4.0), 1.0);
  EXPECT_EQ(studentChance(HUGE_VAL, 4.0), 0.0);
}

TEST(StudentChance, HoldsFarOutInTheTailAndCloseToTheMiddle) {
  for (const double t : {1e-6, 0.01, 0.5, 1.0, 3.0, 40.0, 1e3}) {
    // closed forms for 1 and 2 degrees of freedom; what they leave of 1 is written so that nothing cancels
    const double one = 2.0 / M_PI * std::atan2(1.0, t), two = 2.0 / (2.0 + t * t + t * std::sqrt(2.0 + t * t));
    EXPECT_NEAR(studentChance(t, 1.0) / one, 1.0, 1e-9) << t;
    EXPECT_NEAR(studentChance(t, 2.0) / two, 1.0, 1e-9) << t;
    // with many degrees of freedom the normal distribution's, up to a share of (t^4 + t^2) / (4 v)
    const double normal = std::erfc(t / std::sqrt(2.0));
    if (t <= 3.0) {
      EXPECT_NEAR(studentChance(t, 1e7) / normal, 1.0, 1e-6 + t * t * t * t / 1e7) << t;
    }
  }
}

TEST(SignChance, IsTheCountOfHeads) {
  EXPECT_EQ(signChance(0, 0), 1.0);
  EXPECT_EQ(signChance(5, 5), 1.0);
  EXPECT_NEAR(signChance(1, 0), 1.0, 1e-12);
  EXPECT_NEAR(signChance(10, 0), 2.0 / 1024.0, 1e-12);
  EXPECT_NEAR(signChance(2, 8), 2.0 * (1 + 10 + 45) / 1024.0, 1e-12);
  EXPECT_EQ(signChance(2, 8), signChance(8, 2));
  EXPECT_NEAR(signChance(0, 200) / std::pow(2.0, -199.0), 1.0, 1e-9);
  // 10,000 tosses, 2 standard deviations and the half that a count adds: the normal distribution's to 1 %
  EXPECT_NEAR(signChance(5100, 4900) / std::erfc(1.99 / std::sqrt(2.0)), 1.0, 0.01);
}

TEST(BeyondChance, FollowsHolm) {
  // .05 / 4 = .0125, .05 / 3 = .0167, .05 / 2 = .025: the third fails, and with it the fourth, though it is below .05
  EXPECT_EQ(beyondChance({0.03, 0.01, 0.04, 0.015}, 0.05), (std::vector<bool>{false, true, false, true}));
  EXPECT_EQ(beyondChance({0.0126, 0.0126, 0.0126, 0.0126}, 0.05), std::vector<bool>(4, false));
  EXPECT_EQ(beyondChance({0.0125, 0.016, 0.025, 0.05}, 0.05), std::vector<bool>(4, true));
  EXPECT_TRUE(beyondChance({}, 0.05).empty());
}

}  // namespace
}  // namespace nlg
