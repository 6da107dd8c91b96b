// The fixed links of the support: each point's 32 nearest support points.
//
// Points [0, P) are the support points in pattern order; points [P, P + U) are further ones (test points), which read from
// support points but which nothing reads. A link is undirected: a pair of points that appears in either's list has one index.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "datagen/visibility/segment_kernel.h"

namespace nlg {

inline constexpr int kLinkCount = 32;
// Validity travels along each point's 16 nearest links, at a bit more than half the cost of all 32: a ten-thousandth of all
// points are judged otherwise (docs/theory/visibility.md).
inline constexpr int kCarryingLinkCount = 16;
inline constexpr int kMaxTestPointCount = 65536 - kSupportPointCount;  // a point's index fits 16 bits

struct LinkTable {
  struct Link {
    uint32_t a, b;  // a < b
  };
  struct Edge {
    uint32_t point;  // at the other end
    uint32_t link;   // index into links
  };

  std::vector<LocalPoint> points;         // P + U, local coordinates
  std::vector<Link> links;                // 142,308 for the support points alone; a link's index is its place in link_packets
  std::vector<Edge> nearest;              // (P + U) x 32, nearest first; ties go to the lower index of the mirrored pair
  std::vector<float> distance;            // (P + U) x 32, local units
  std::vector<uint32_t> first_edge;       // P + U + 1: edges of point p are [first_edge[p], first_edge[p + 1]), and among them
  std::vector<uint32_t> first_test_edge;  // P + U: from here on those that lead to test points
  std::vector<uint16_t> edge_point;       // every carrying link at both its ends: the point at the other end,
  std::vector<uint32_t> edge_link;        // and the link
  LinkPackets link_packets;               // the links, and
  PointPackets point_packets;             // the points, as the segment tests read them

  int pointCount() const { return static_cast<int>(points.size()); }
};

// The 32 support points nearest to any place, nearest first: the links that a further point there has.
struct NearestPoints {
  std::array<uint32_t, kLinkCount> point;
  std::array<float, kLinkCount> distance;  // local units
};
NearestPoints nearestSupportPoints(const LocalPoint& place);

// Segments between points, packed as the segment tests read them.
// pairs   from << 32 | to, indices into points; at least one
LinkPackets makeLinkPackets(const std::vector<LocalPoint>& points, const std::vector<uint64_t>& pairs);

// The table for the support pattern and `test` further points, at most kMaxTestPointCount.
LinkTable makeLinkTable(const std::vector<LocalPoint>& test);

}  // namespace nlg
