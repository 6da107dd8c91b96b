#include "datagen/visibility/link_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace nlg {
namespace {

constexpr int kTest = 200;

const LinkTable& table() {
  static const LinkTable links = makeLinkTable(testPoints(kTest));
  return links;
}

const LinkTable::Edge& nearest(uint32_t point, int k) { return table().nearest[size_t(point) * kLinkCount + k]; }

double distanceBetween(uint32_t a, uint32_t b) {
  const LocalPoint &p = table().points[a], &q = table().points[b];
  return std::hypot(double{p[0]} - q[0], double{p[1]} - q[1], double{p[2]} - q[2]);
}

TEST(LinkTable, ListsThe32NearestByBruteForce) {
  for (uint32_t point = 0; point < table().points.size(); point += point < kSupportPointCount ? 37 : 5) {
    std::vector<double> distances;
    for (uint32_t other = 0; other < kSupportPointCount; ++other) {
      if (other != point) distances.push_back(distanceBetween(point, other));
    }
    std::sort(distances.begin(), distances.end());
    std::set<uint32_t> listed;
    for (int k = 0; k < kLinkCount; ++k) {
      const uint32_t other = nearest(point, k).point;
      ASSERT_TRUE(other < kSupportPointCount && other != point) << "point " << point << ", neighbour " << k;
      listed.insert(other);
      // ties may be listed either way: distances decide. Squares are in float: 4 roundings
      ASSERT_NEAR(distanceBetween(point, other), distances[k], 4 * 0x1p-24 * distances[k])
          << "point " << point << ", neighbour " << k;
      ASSERT_NEAR(table().distance[size_t(point) * kLinkCount + k], distances[k], 4 * 0x1p-24 * distances[k])
          << "point " << point;
    }
    ASSERT_EQ(listed.size(), size_t{kLinkCount}) << "point " << point << " lists one twice";
  }
}

TEST(LinkTable, IsMirroredExactly) {
  for (uint32_t mirror = 1; mirror < kMirrorCount; ++mirror) {
    const uint32_t flip = mirror * kOctantPointCount;
    for (uint32_t point = 0; point < kSupportPointCount; ++point) {
      for (int k = 0; k < kLinkCount; ++k) {
        ASSERT_EQ(nearest(point ^ flip, k).point, nearest(point, k).point ^ flip) << "mirror " << mirror << ", point " << point;
        ASSERT_EQ(table().distance[size_t(point ^ flip) * kLinkCount + k], table().distance[size_t(point) * kLinkCount + k]);
      }
    }
  }
}

TEST(LinkTable, ListsEveryCarryingLinkAtBothEndsSupportPointsFirst) {
  ASSERT_EQ(table().first_edge.size(), table().points.size() + 1);
  ASSERT_EQ(table().edge_point.size(), table().first_edge.back());
  ASSERT_EQ(table().edge_link.size(), table().first_edge.back());
  std::vector<int> visits(table().links.size(), 0);
  for (uint32_t point = 0; point < table().points.size(); ++point) {
    for (uint32_t e = table().first_edge[point]; e < table().first_edge[point + 1]; ++e) {
      const LinkTable::Link& link = table().links[table().edge_link[e]];
      const uint32_t other = table().edge_point[e];
      ASSERT_TRUE((link.a == point && link.b == other) || (link.b == point && link.a == other)) << "edge " << e;
      ASSERT_EQ(e < table().first_test_edge[point], other < kSupportPointCount) << "edge " << e;
      ++visits[table().edge_link[e]];
    }
  }
  std::vector<int> expected(table().links.size(), 0);
  for (uint32_t point = 0; point < table().points.size(); ++point) {
    for (int k = 0; k < kCarryingLinkCount; ++k) expected[nearest(point, k).link] = 2;
  }
  EXPECT_EQ(visits, expected);
}

}  // namespace
}  // namespace nlg
