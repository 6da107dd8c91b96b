#include "datagen/visibility/link_table.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "tool/error.h"

namespace nlg {
namespace {

constexpr uint32_t kNoPoint = 0xffffffffu;

struct Neighbour {
  float squared_distance;
  uint32_t order;  // breaks ties the same way in all mirror images
  uint32_t point;
  bool operator<(const Neighbour& other) const {
    return squared_distance != other.squared_distance ? squared_distance < other.squared_distance : order < other.order;
  }
};

// The 32 support points nearest to `point`, itself (index self, or kNoPoint) left out.
std::vector<Neighbour> neighboursOf(const LocalPoint& point, uint32_t self) {
  const std::vector<LocalPoint>& support = supportPattern().points;
  const uint32_t mirror = self < kSupportPointCount ? self / kOctantPointCount : 0;
  std::vector<Neighbour> found;
  found.reserve(support.size());
  for (uint32_t i = 0; i < support.size(); ++i) {
    if (i == self) continue;
    const float dx = support[i][0] - point[0], dy = support[i][1] - point[1], dz = support[i][2] - point[2];
    found.push_back({dx * dx + dy * dy + dz * dz, i ^ (mirror * kOctantPointCount), i});
  }
  std::partial_sort(found.begin(), found.begin() + kLinkCount, found.end());
  found.resize(kLinkCount);
  return found;
}

// Support points of mirror m are linked as those of mirror 0 are, mirrored: computed once, copied seven times.
void findNearest(LinkTable& table) {
  table.nearest.resize(table.points.size() * kLinkCount);
  table.distance.resize(table.nearest.size());
  const auto set = [&](uint32_t point, int k, uint32_t neighbour, float squared_distance) {
    table.nearest[size_t(point) * kLinkCount + k] = {neighbour, 0};
    table.distance[size_t(point) * kLinkCount + k] = std::sqrt(squared_distance);
  };
  // exclusive or by the mirror takes each neighbour into the mirrored octant (docs/theory/math.md, section 2)
  for (uint32_t i = 0; i < kOctantPointCount; ++i) {
    const std::vector<Neighbour> neighbours = neighboursOf(table.points[i], i);
    for (uint32_t mirror = 0; mirror < kMirrorCount; ++mirror) {
      for (int k = 0; k < kLinkCount; ++k) {
        set(mirror * kOctantPointCount + i, k, neighbours[k].point ^ (mirror * kOctantPointCount),
            neighbours[k].squared_distance);
      }
    }
  }
  // test points have no mirror images: each is searched for itself
  for (uint32_t i = kSupportPointCount; i < table.points.size(); ++i) {
    const std::vector<Neighbour> neighbours = neighboursOf(table.points[i], i);
    for (int k = 0; k < kLinkCount; ++k) set(i, k, neighbours[k].point, neighbours[k].squared_distance);
  }
}

std::array<AlignedFloats, 3> gather(const std::vector<LocalPoint>& points, const std::vector<uint32_t>& order) {
  std::array<AlignedFloats, 3> gathered;
  for (int axis = 0; axis < 3; ++axis) {
    gathered[axis].reserve(order.size());
    for (const uint32_t point : order) gathered[axis].push_back(points[point][axis]);
  }
  return gathered;
}

// The links of the table are the pairs in the order of their packets.
void packLinks(const std::vector<uint64_t>& pairs, LinkTable& table) {
  table.link_packets = makeLinkPackets(table.points, pairs);
  const LinkPackets& packets = table.link_packets;
  for (size_t place = 0; place < pairs.size(); ++place) {
    table.links.push_back({packets.from_point[place], packets.to_point[place]});
  }
}

// Gives every unordered pair one index.
void indexLinks(LinkTable& table) {
  std::vector<uint64_t> pairs;
  pairs.reserve(table.nearest.size());
  const auto pairOf = [&](size_t entry) {
    const uint64_t p = entry / kLinkCount, q = table.nearest[entry].point;
    return std::min(p, q) << 32 | std::max(p, q);
  };
  for (size_t entry = 0; entry < table.nearest.size(); ++entry) pairs.push_back(pairOf(entry));
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  packLinks(pairs, table);
  std::vector<uint32_t> place_of_pair(pairs.size());
  for (uint32_t place = 0; place < pairs.size(); ++place) place_of_pair[table.link_packets.tree.order[place]] = place;
  for (size_t entry = 0; entry < table.nearest.size(); ++entry) {
    const auto found = std::lower_bound(pairs.begin(), pairs.end(), pairOf(entry));
    table.nearest[entry].link = place_of_pair[static_cast<size_t>(found - pairs.begin())];
  }
}

// Lists the links that carry validity at both their ends; edges that lead to support points come first.
void listEdges(LinkTable& table) {
  // a link carries if it is among the 16 nearest of either end
  std::vector<uint8_t> carries(table.links.size(), 0);
  for (size_t entry = 0; entry < table.nearest.size(); ++entry) {
    if (entry % kLinkCount < kCarryingLinkCount) carries[table.nearest[entry].link] = 1;
  }
  // counts by point become the first edge of each: lists without gaps, no allocation a point
  table.first_edge.assign(table.points.size() + 1, 0);
  for (uint32_t l = 0; l < table.links.size(); ++l) {
    table.first_edge[table.links[l].a + 1] += carries[l];
    table.first_edge[table.links[l].b + 1] += carries[l];
  }
  std::partial_sum(table.first_edge.begin(), table.first_edge.end(), table.first_edge.begin());
  table.edge_point.resize(table.first_edge.back());
  table.edge_link.resize(table.first_edge.back());
  std::vector<uint32_t> next(table.first_edge.begin(), table.first_edge.end() - 1);
  const auto list = [&](uint32_t from, uint32_t to, uint32_t link) {
    table.edge_point[next[from]] = static_cast<uint16_t>(to);
    table.edge_link[next[from]++] = link;
  };
  // support points first: what reads them alone stops at first_test_edge
  for (const bool to_support : {true, false}) {
    for (uint32_t l = 0; l < table.links.size(); ++l) {
      if (!carries[l]) continue;
      const LinkTable::Link& link = table.links[l];
      if ((link.b < kSupportPointCount) == to_support) list(link.a, link.b, l);
      if ((link.a < kSupportPointCount) == to_support) list(link.b, link.a, l);
    }
    if (to_support) table.first_test_edge = next;
  }
}

void packPoints(LinkTable& table) {
  std::vector<ItemBox> boxes;
  for (const LocalPoint& point : table.points) boxes.push_back({point, point});
  table.point_packets.tree = makePacketTree(boxes);
  table.point_packets.at = gather(table.points, table.point_packets.tree.order);
}

}  // namespace

LinkPackets makeLinkPackets(const std::vector<LocalPoint>& points, const std::vector<uint64_t>& pairs) {
  std::vector<ItemBox> boxes;
  boxes.reserve(pairs.size());
  for (const uint64_t pair : pairs) {
    const LocalPoint &a = points[pair >> 32], &b = points[static_cast<uint32_t>(pair)];
    ItemBox box;
    for (int axis = 0; axis < 3; ++axis) std::tie(box.low[axis], box.high[axis]) = std::minmax(a[axis], b[axis]);
    boxes.push_back(box);
  }
  LinkPackets packets;
  packets.tree = makePacketTree(boxes);
  for (const uint32_t item : packets.tree.order) {
    packets.from_point.push_back(static_cast<uint32_t>(pairs[item] >> 32));
    packets.to_point.push_back(static_cast<uint32_t>(pairs[item]));
  }
  packets.from = gather(points, packets.from_point);
  packets.to = gather(points, packets.to_point);
  return packets;
}

NearestPoints nearestSupportPoints(const LocalPoint& place) {
  const std::vector<Neighbour> neighbours = neighboursOf(place, kNoPoint);
  NearestPoints nearest;
  for (int k = 0; k < kLinkCount; ++k) {
    nearest.point[k] = neighbours[k].point;
    nearest.distance[k] = std::sqrt(neighbours[k].squared_distance);
  }
  return nearest;
}

LinkTable makeLinkTable(const std::vector<LocalPoint>& test) {
  NLG_CHECK(test.size(), <=, static_cast<size_t>(kMaxTestPointCount));
  LinkTable table;
  table.points = supportPattern().points;
  table.points.insert(table.points.end(), test.begin(), test.end());
  findNearest(table);
  indexLinks(table);
  listEdges(table);
  packPoints(table);
  return table;
}

}  // namespace nlg
