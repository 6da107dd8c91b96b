#include "runtime_eval/support/point_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace nlg {
namespace {

const std::vector<LocalPoint>& points() { return supportPattern().points; }

TEST(SupportPattern, HasTheHashThatTravelsWithArtefacts) {
  // golden: a change of one bit of one coordinate makes every stored artefact foreign
  EXPECT_EQ(supportPattern().hash, 0x37ee02039e27bac5u);
  EXPECT_EQ(supportPattern().hash, hashPoints(points()));
}

TEST(SupportPattern, IsItsOwnMirrorImage) {
  for (int mirror = 0; mirror < kMirrorCount; ++mirror) {
    for (int i = 0; i < kSupportPointCount; ++i) {
      LocalPoint image = points()[i];
      for (int axis = 0; axis < 3; ++axis) image[axis] *= (mirror >> axis) & 1 ? -1.0f : 1.0f;
      ASSERT_EQ(image, points()[i ^ (mirror * kOctantPointCount)]) << "mirror " << mirror << ", point " << i;
    }
  }
}

TEST(SupportPattern, NumbersMirrorsByTheirSigns) {
  for (int i = 0; i < kSupportPointCount; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(points()[i][axis] < 0, ((i / kOctantPointCount) >> axis & 1) == 1) << "point " << i << ", axis " << axis;
    }
  }
}

TEST(Strata, PartitionTheSupport) {
  const PointSet& set = stratifiedSupportPoints();
  ASSERT_EQ(set.count, kSupportPointCount);
  ASSERT_EQ(set.padded_count, kSupportPointCount);
  std::set<int> seen;
  for (int k = 0; k < kStratumCount; ++k) {
    for (int m = 0; m < kMirrorCount; ++m) {
      for (int j = 0; j < 128; ++j) {
        const int at = k * kStratumPointCount + j % 4 * kMinibatchPointCount + m * 32 + j / 4;
        const int index = m * kOctantPointCount + 8 * j + k;
        ASSERT_EQ(stratifiedPatternIndex(at), index);
        seen.insert(index);
        ASSERT_EQ((LocalPoint{set.x[at], set.y[at], set.z[at]}), points()[index]) << "stratum order " << at;
        ASSERT_EQ(set.tent[at], tent(points()[index])) << "stratum order " << at;
      }
    }
  }
  EXPECT_EQ(seen.size(), size_t{kSupportPointCount});
}

TEST(SamplePoints, AreSharedByTheProbesOfACell) {
  const std::vector<LocalPoint>& points = supportPattern().points;
  std::set<LocalPoint> octant;
  for (const uint16_t point : octantSamples()) octant.insert(points[point]);
  ASSERT_EQ(octant.size(), size_t{kOctantSampleCount});
  std::map<std::array<int, 3>, int> in_cell;
  for (const LocalPoint& point : octant) {
    ++in_cell[{static_cast<int>(4 * point[0]), static_cast<int>(4 * point[1]), static_cast<int>(4 * point[2])}];
    for (int axis = 0; axis < 3; ++axis) {
      LocalPoint image = point;
      image[axis] = 1.0f - point[axis];
      EXPECT_TRUE(octant.contains(image)) << "axis " << axis;
    }
  }
  EXPECT_EQ(in_cell.size(), 64u);
  for (const auto& [cell, count] : in_cell) EXPECT_EQ(count, 2);
  // the same in every mirror
  EXPECT_EQ(supportPointOf(5 * kOctantSampleCount + 7), size_t{5 * kOctantPointCount} + octantSamples()[7]);
}

TEST(TestPoints, ExtendShorterSets) {
  EXPECT_TRUE(testPoints(0).empty());
  const std::vector<LocalPoint> longer = testPoints(4096);
  const std::vector<LocalPoint> shorter = testPoints(100);
  EXPECT_TRUE(std::equal(shorter.begin(), shorter.end(), longer.begin()));
}

TEST(TestPoints, AreInsideDistinctAndNoSupportPoints) {
  std::set<LocalPoint> all(points().begin(), points().end());
  for (const LocalPoint& point : testPoints(65536)) {
    ASSERT_TRUE(all.insert(point).second) << point[0] << ' ' << point[1] << ' ' << point[2];
    for (const float coordinate : point) ASSERT_TRUE(std::fabs(coordinate) < 1.0f) << coordinate;
  }
}

}  // namespace
}  // namespace nlg
