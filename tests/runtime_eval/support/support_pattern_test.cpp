#include "nlg/support.h"
#include "runtime_eval/support/point_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace nlg {
namespace {

const std::vector<LocalPoint>& points() { return supportPattern().points; }

double distance(const LocalPoint& a, const LocalPoint& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

// The densest packing of N spheres in a unit cube has centres about (sqrt(2) / N)^(1/3) apart.
double packingDistance(int count) { return std::cbrt(std::sqrt(2.0) / count); }

TEST(SupportPattern, HasTheHashThatTravelsWithArtefacts) {
  // golden: a change of one bit of one coordinate makes every stored artefact foreign
  EXPECT_EQ(supportPattern().hash, 0x37ee02039e27bac5u);
  EXPECT_EQ(supportPattern().hash, hashPoints(points()));
}

TEST(SupportPattern, LiesOnTheLatticeAwayFromMirrorPlanesAndBorder) {
  ASSERT_EQ(points().size(), size_t{kSupportPointCount});
  for (int i = 0; i < kSupportPointCount; ++i) {
    for (const float coordinate : points()[i]) {
      const double lattice = std::fabs(double{coordinate}) * 65536.0;
      ASSERT_EQ(lattice, std::floor(lattice)) << "point " << i;
      ASSERT_TRUE(lattice > 0 && lattice < 65536) << "point " << i << ": " << coordinate;
    }
  }
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

TEST(SupportPattern, SharesTheCellWithItsOtherProbes) {
  // the octant of mirror m, seen from the cell's corner (0, 0, 0), is the octant of mirror 0
  const std::set<LocalPoint> cell(points().begin(), points().begin() + kOctantPointCount);
  for (int i = 0; i < kSupportPointCount; ++i) {
    LocalPoint place = points()[i];
    for (float& coordinate : place) coordinate += coordinate < 0 ? 1.0f : 0.0f;  // exact: multiples of 2^-16
    ASSERT_EQ(cell.count(place), 1u) << "point " << i;
  }
}

TEST(SupportPattern, StandsOnBothSidesOfEveryWallAlongAnAxis) {
  // 256 values an axis, 4 points each, none farther than half a step from even spacing
  for (int axis = 0; axis < 3; ++axis) {
    std::map<int, int> counts;
    for (int i = 0; i < kOctantPointCount; ++i) {
      const float step = points()[i][axis] * 256.0f;
      ++counts[static_cast<int>(step)];
      ASSERT_NEAR(step - std::floor(step), 0.5, 0.25) << "point " << i << ", axis " << axis;
    }
    ASSERT_EQ(counts.size(), 256u) << "axis " << axis;
    for (const auto& [value, count] : counts) ASSERT_EQ(count, 4) << "axis " << axis << ", value " << value;
  }
}

TEST(SupportPattern, KeepsPointsApart) {
  // Images in a plane may come near; from all other points a point keeps three quarters of the distance of the densest packing in
  // the mean. Independent points would keep half of it: .554 n^(-1/3) of 1.122 n^(-1/3).
  double sum = 0;
  for (int i = 0; i < kOctantPointCount; ++i) {
    double nearest = 2.0;
    for (int k = 0; k < kOctantPointCount; ++k) {
      if (k != i) nearest = std::min(nearest, distance(points()[i], points()[k]));
    }
    EXPECT_GE(nearest, 1.0 / 512) << "point " << i;
    sum += nearest;
  }
  EXPECT_GE(sum / kOctantPointCount, 0.75 * packingDistance(kOctantPointCount));
}

TEST(SupportPattern, LeavesNoHole) {
  // A place that is farther than the packing distance from all points, and from its own images in the mirror planes and in the
  // border, has room for another point.
  const double largest = packingDistance(kOctantPointCount);
  for (const LocalPoint& place : testPoints(4000)) {
    const auto has_room = [&](float c) { return std::fabs(c) > largest / 2 && std::fabs(c) < 1 - largest / 2; };
    if (!has_room(place[0]) || !has_room(place[1]) || !has_room(place[2])) continue;
    double nearest = 2.0;
    for (const LocalPoint& point : points()) nearest = std::min(nearest, distance(place, point));
    ASSERT_LE(nearest, largest) << place[0] << ' ' << place[1] << ' ' << place[2];
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

TEST(Strata, AreAsWellSpreadAsThePattern) {
  // of the 16 points of a cell of a quarter of a spacing a stratum has two; along an axis nearly all of its values differ
  for (int stratum = 0; stratum < kStratumCount; ++stratum) {
    std::map<int, int> counts;
    std::array<std::set<float>, 3> values;
    for (int i = stratum; i < kOctantPointCount; i += kStratumCount) {
      int cell = 0;
      for (int axis = 0; axis < 3; ++axis) {
        cell = cell * 4 + static_cast<int>(points()[i][axis] * 4);
        values[axis].insert(points()[i][axis]);
      }
      ++counts[cell];
    }
    ASSERT_EQ(counts.size(), 64u) << "an empty cell";
    for (const auto& [cell, count] : counts) ASSERT_EQ(count, 2) << "stratum " << stratum << ", cell " << cell;
    for (const std::set<float>& axis : values) EXPECT_GE(axis.size(), 110u) << "stratum " << stratum;
  }
}

TEST(Tent, IsTheProductOfThreeRamps) {
  EXPECT_EQ(tent({0, 0, 0}), 1.0f);
  EXPECT_EQ(tent({0.5f, -0.5f, 0.25f}), 0.1875f);
  EXPECT_EQ(tent({1, 0, 0}), 0.0f);
  EXPECT_EQ(tent({0, -1.5f, 0}), 0.0f);
  EXPECT_EQ(tent({2, 2, 0}), 0.0f);  // two negative ramps are no positive product
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

TEST(TestPoints, FillAllOctantsEvenly) {
  // low discrepancy: far closer to a share of an eighth than independent points, whose deviation is sqrt(2048 * 7/64) = 15
  std::array<int, 8> counts{};
  for (const LocalPoint& p : testPoints(2048)) ++counts[(p[0] < 0) + 2 * (p[1] < 0) + 4 * (p[2] < 0)];
  for (int octant = 0; octant < 8; ++octant) EXPECT_NEAR(counts[octant], 256, 15) << "octant " << octant;
}

TEST(PointSet, PadsWithCopiesOfTheFirstPoint) {
  for (const int count : {0, 1, 15, 16, 17, 33}) {
    const std::vector<LocalPoint> list = testPoints(count);
    const PointSet set = makePointSet(list);
    ASSERT_EQ(set.count, count);
    ASSERT_EQ(set.padded_count, (count + 15) / 16 * 16);
    for (int i = 0; i < set.padded_count; ++i) {
      const LocalPoint& expected = list[i < count ? i : 0];
      ASSERT_EQ((LocalPoint{set.x[i], set.y[i], set.z[i]}), expected) << count << " points, at " << i;
      ASSERT_EQ(set.tent[i], tent(expected));
    }
  }
}

TEST(HashPoints, DependsOnEveryBitAndOnOrder) {
  std::vector<LocalPoint> list = testPoints(3);
  const uint64_t hash = hashPoints(list);
  std::swap(list[0], list[1]);
  EXPECT_NE(hashPoints(list), hash);
  std::swap(list[0], list[1]);
  list[2][2] = std::nextafter(list[2][2], 2.0f);
  EXPECT_NE(hashPoints(list), hash);
  EXPECT_EQ(hashPoints({}), 0xcbf29ce484222325u);  // FNV-1a's offset
}

}  // namespace
}  // namespace nlg
