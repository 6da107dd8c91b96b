#include "datagen/visibility/link_table.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace nlg {
namespace {

struct Neighbour {
  float squared_distance;
  uint32_t order;  // breaks ties the same way in all mirror images
  uint32_t point;
  bool operator<(const Neighbour& other) const {
    return squared_distance != other.squared_distance ? squared_distance < other.squared_distance : order < other.order;
  }
};

// The 32 support points nearest to `point`, itself (index self, or none) left out.
std::vector<Neighbour> nearestSupportPoints(const LocalPoint& point, uint32_t self) {
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
  for (uint32_t i = 0; i < kOctantPointCount; ++i) {
    const std::vector<Neighbour> neighbours = nearestSupportPoints(table.points[i], i);
    for (uint32_t mirror = 0; mirror < kMirrorCount; ++mirror) {
      for (int k = 0; k < kLinkCount; ++k) {
        set(mirror * kOctantPointCount + i, k, neighbours[k].point ^ (mirror * kOctantPointCount),
            neighbours[k].squared_distance);
      }
    }
  }
  for (uint32_t i = kSupportPointCount; i < table.points.size(); ++i) {
    const std::vector<Neighbour> neighbours = nearestSupportPoints(table.points[i], i);
    for (int k = 0; k < kLinkCount; ++k) set(i, k, neighbours[k].point, neighbours[k].squared_distance);
  }
}

// Gives every unordered pair one index and lists it at both ends.
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
  for (size_t entry = 0; entry < table.nearest.size(); ++entry) {
    const auto found = std::lower_bound(pairs.begin(), pairs.end(), pairOf(entry));
    table.nearest[entry].link = static_cast<uint32_t>(found - pairs.begin());
  }
  table.first_edge.assign(table.points.size() + 1, 0);
  for (const uint64_t pair : pairs) {
    table.links.push_back({static_cast<uint32_t>(pair >> 32), static_cast<uint32_t>(pair)});
    ++table.first_edge[table.links.back().a + 1];
    ++table.first_edge[table.links.back().b + 1];
  }
  std::partial_sum(table.first_edge.begin(), table.first_edge.end(), table.first_edge.begin());
  table.edges.resize(2 * table.links.size());
  std::vector<uint32_t> next(table.first_edge.begin(), table.first_edge.end() - 1);
  for (uint32_t l = 0; l < table.links.size(); ++l) {
    table.edges[next[table.links[l].a]++] = {table.links[l].b, l};
    table.edges[next[table.links[l].b]++] = {table.links[l].a, l};
  }
}

}  // namespace

LinkTable makeLinkTable(const std::vector<LocalPoint>& unseen) {
  LinkTable table;
  table.points = supportPattern().points;
  table.points.insert(table.points.end(), unseen.begin(), unseen.end());
  findNearest(table);
  indexLinks(table);
  return table;
}

}  // namespace nlg
