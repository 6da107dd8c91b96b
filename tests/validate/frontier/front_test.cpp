#include "validate/frontier/front.h"

#include <gtest/gtest.h>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

constexpr FrontTolerances kExact{0.0, 0.0};
constexpr FrontTolerances kTenth{0.1, 0.1};

using Members = std::vector<bool>;

TEST(Front, HoldsThePointsThatNoOtherBeats) {
  const std::vector<FrontPoint> points = {{10, 4}, {20, 2}, {20, 3}, {5, 9}, {40, 1}, {50, 1.5}};
  EXPECT_EQ(frontMembers(points, kExact), (Members{true, true, false, true, true, false}));
}

TEST(Front, TakesNoMemberForAGainWithinTheNoise) {
  // slower by half and better by 5 % only; faster by 5 % only and twice as wrong
  EXPECT_EQ(frontMembers({{10, 1.0}, {15, 0.95}}, kTenth), (Members{true, false}));
  EXPECT_EQ(frontMembers({{10.0, 2.0}, {10.5, 1.0}}, kTenth), (Members{false, true}));
}

TEST(Front, SeesManySmallGainsAsTheLargeOneThatTheyAddUpTo) {
  // each is 6 % better than the one before: every second one is a member
  std::vector<FrontPoint> points;
  for (double us = 10, rmse = 1; points.size() < 6; us *= 2, rmse *= 0.94) points.push_back({us, rmse});
  EXPECT_EQ(frontMembers(points, kTenth), (Members{true, false, true, false, true, false}));
}

TEST(Front, LetsTheFirstOfEqualPointsStandForAll) {
  // the second measured a little faster, the third a little better
  EXPECT_EQ(frontMembers({{10.0, 1.0}, {9.8, 1.0}, {10.2, 0.98}}, kTenth), (Members{true, false, false}));
}

TEST(Front, HasAMemberAsGoodAndAsFastAsAnyPointUpToTheTolerances) {
  // of random points: the fastest that is as good is no further than two tolerances away, since a member may stand for another
  for (uint64_t seed = 0; seed < 50; ++seed) {
    Random random(seed);
    std::vector<FrontPoint> points(40);
    for (FrontPoint& point : points) point = {std::exp(random.normal()), std::exp(random.normal())};
    const Members members = frontMembers(points, kTenth);
    double least_rmse = INFINITY, least_member = INFINITY;
    for (size_t i = 0; i < points.size(); ++i) {
      least_rmse = std::min(least_rmse, points[i].error);
      if (members[i]) least_member = std::min(least_member, points[i].error);
    }
    EXPECT_LE(least_member, least_rmse * 1.1 * 1.1) << "seed " << seed;
    for (size_t a = 0; a < points.size(); ++a) {
      for (size_t b = 0; b < points.size(); ++b) {
        const bool beats = points[b].us < points[a].us && points[b].error * 1.1 < points[a].error;
        EXPECT_FALSE(members[a] && beats) << "seed " << seed << ": " << b << " beats member " << a;
      }
    }
  }
}

}  // namespace
}  // namespace nlg
