#include "datagen/visibility/cell_links.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

namespace nlg {
namespace {

using Place = std::array<double, 3>;

Place placeOf(size_t point, const std::array<int8_t, 3>& away = {}) {
  Place place;
  for (int axis = 0; axis < 3; ++axis) place[axis] = double{cellPoint(point)[axis]} + away[axis];
  return place;
}

double distanceBetween(const Place& a, const Place& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

const CellLinks::Edge& nearest(size_t point, int k) { return cellLinks().nearest[point * kLinkCount + k]; }

TEST(CellLinks, NamesThePointsOfItsEightProbesAlike) {
  const std::vector<LocalPoint>& support = supportPattern().points;
  for (int corner = 0; corner < kCellCorners; ++corner) {
    for (size_t i = 0; i < kOctantPointCount; ++i) {
      const size_t point = cellLinks().point_of[corner][i];
      ASSERT_EQ(cellLinks().point_of[corner][point], i) << "corner " << corner;
      const LocalPoint& seen_from_corner = support[static_cast<size_t>(corner) * kOctantPointCount + i];
      for (int axis = 0; axis < 3; ++axis)
        ASSERT_EQ(seen_from_corner[axis] + static_cast<float>(corner >> axis & 1), cellPoint(point)[axis]) << "corner " << corner;
    }
  }
}

TEST(CellLinks, ListsThe32NearestByBruteForce) {
  for (size_t point = 0; point < kOctantPointCount; point += 7) {
    std::vector<double> distances;
    for (size_t other = 0; other < kOctantPointCount; ++other) {
      for (int n = 0; n < 27; ++n) {
        const std::array<int8_t, 3> away = {static_cast<int8_t>(n % 3 - 1), static_cast<int8_t>(n / 3 % 3 - 1),
                                            static_cast<int8_t>(n / 9 - 1)};
        if (other != point || n != 13) distances.push_back(distanceBetween(placeOf(point), placeOf(other, away)));
      }
    }
    std::sort(distances.begin(), distances.end());
    std::set<std::tuple<std::array<int8_t, 3>, uint16_t>> listed;
    for (int k = 0; k < kLinkCount; ++k) {
      const CellLinks::Edge& edge = nearest(point, k);
      listed.insert({edge.away, edge.point});
      ASSERT_NEAR(distanceBetween(placeOf(point), placeOf(edge.point, edge.away)), distances[k], 1e-12) << point;
      ASSERT_NEAR(cellLinks().distance[point * kLinkCount + k], distances[k], 0x1p-24 * distances[k]) << point;
      ASSERT_LT(distances[k], kCellReach - 0.5) << point;
    }
    ASSERT_EQ(listed.size(), size_t{kLinkCount}) << "point " << point << " lists one twice";
  }
}

TEST(CellLinks, AreMirroredExactly) {
  for (int mirror = 1; mirror < kCellCorners; ++mirror) {
    const auto& image_of = cellLinks().point_of[mirror];
    for (size_t point = 0; point < kOctantPointCount; ++point) {
      for (int k = 0; k < kLinkCount; ++k) {
        const CellLinks::Edge &edge = nearest(point, k), &image = nearest(image_of[point], k);
        ASSERT_EQ(image.point, image_of[edge.point]) << "mirror " << mirror << ", point " << point;
        for (int axis = 0; axis < 3; ++axis) ASSERT_EQ(image.away[axis], mirror >> axis & 1 ? -edge.away[axis] : edge.away[axis]);
      }
    }
  }
}

// A link is the same segment from whichever end, and packed where it says.
TEST(CellLinks, HaveOneNumberFromBothEnds) {
  std::map<uint16_t, std::set<std::array<Place, 2>>> segments;
  for (size_t point = 0; point < kOctantPointCount; ++point) {
    for (int k = 0; k < kLinkCount; ++k) {
      const CellLinks::Edge& edge = nearest(point, k);
      Place from = placeOf(point), to = placeOf(edge.point, edge.away);
      // as the owner's cell sees it
      for (int axis = 0; axis < 3 && edge.is_theirs; ++axis) from[axis] -= edge.away[axis], to[axis] -= edge.away[axis];
      segments[edge.link].insert({std::min(from, to), std::max(from, to)});
      const LinkPackets& packets = cellLinks().packets;
      std::array<Place, 2> packed;
      for (int axis = 0; axis < 3; ++axis) {
        packed[0][axis] = 0.5 + kCellReach * packets.from[axis][edge.link];
        packed[1][axis] = 0.5 + kCellReach * packets.to[axis][edge.link];
      }
      // floats of up to 1
      ASSERT_LT(std::min(distanceBetween(packed[0], from), distanceBetween(packed[1], from)), 1e-6);
      ASSERT_LT(std::min(distanceBetween(packed[0], to), distanceBetween(packed[1], to)), 1e-6);
    }
  }
  for (const auto& [link, ends] : segments) ASSERT_EQ(ends.size(), 1u) << "link " << link;
  EXPECT_EQ(segments.size(), 16932u);
}

TEST(CellLinks, CarryWithinTheCellAtBothEnds) {
  std::set<std::tuple<size_t, uint16_t, uint16_t>> expected, listed;
  for (size_t point = 0; point < kOctantPointCount; ++point) {
    for (int k = 0; k < kCarryingLinkCount; ++k) {
      const CellLinks::Edge& edge = nearest(point, k);
      if (edge.away != std::array<int8_t, 3>{}) continue;
      expected.insert({point, edge.point, edge.link});
      expected.insert({edge.point, static_cast<uint16_t>(point), edge.link});
    }
    for (uint32_t e = cellLinks().first_inner[point]; e < cellLinks().first_inner[point + 1]; ++e)
      ASSERT_TRUE(listed.insert({point, cellLinks().inner[e].point, cellLinks().inner[e].link}).second) << point;
  }
  EXPECT_EQ(listed, expected);
}

}  // namespace
}  // namespace nlg
