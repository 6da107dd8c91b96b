// The links of further points of a support, which read from its support points and from which none of them reads: test points.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "datagen/visibility/cell_links.h"

namespace nlg {

inline constexpr int kMaxTestPointCount = 65536 - kSupportPointCount;

// The 32 support points nearest to any place, nearest first: the links that a further point there has.
struct NearestPoints {
  std::array<uint32_t, kLinkCount> point;
  std::array<float, kLinkCount> distance;  // local units
};
NearestPoints nearestSupportPoints(const LocalPoint& place);

struct TestLinks {
  std::vector<LocalPoint> points;  // U, local coordinates
  std::vector<NearestPoints> nearest;
  PointPackets point_packets;  // none without points, and …
  LinkPackets link_packets;
  std::vector<uint32_t> place;  // U x 32: of each link in link_packets
};

// points   at most kMaxTestPointCount
TestLinks makeTestLinks(const std::vector<LocalPoint>& points);

}  // namespace nlg
