#include "datagen/visibility/test_links.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tool/error.h"

namespace nlg {

NearestPoints nearestSupportPoints(const LocalPoint& place) {
  const std::vector<LocalPoint>& support = supportPattern().points;
  std::vector<std::pair<float, uint32_t>> found;  // squared distance, point
  found.reserve(support.size());
  for (uint32_t i = 0; i < support.size(); ++i) {
    const float dx = support[i][0] - place[0], dy = support[i][1] - place[1], dz = support[i][2] - place[2];
    found.emplace_back(dx * dx + dy * dy + dz * dz, i);
  }
  std::partial_sort(found.begin(), found.begin() + kLinkCount, found.end());
  NearestPoints nearest;
  for (int k = 0; k < kLinkCount; ++k) {
    nearest.point[k] = found[k].second;
    nearest.distance[k] = std::sqrt(found[k].first);
  }
  return nearest;
}

TestLinks makeTestLinks(const std::vector<LocalPoint>& points) {
  NLG_CHECK(points.size(), <=, static_cast<size_t>(kMaxTestPointCount));
  TestLinks links;
  links.points = points;
  if (points.empty()) return links;
  std::vector<LocalPoint> ends = supportPattern().points;
  ends.insert(ends.end(), points.begin(), points.end());
  std::vector<uint64_t> pairs;
  for (uint64_t i = 0; i < points.size(); ++i) {
    links.nearest.push_back(nearestSupportPoints(points[i]));
    for (const uint32_t support : links.nearest.back().point) pairs.push_back((kSupportPointCount + i) << 32 | support);
  }
  links.point_packets = makePointPackets(points);
  links.link_packets = makeLinkPackets(ends, pairs);
  links.place.resize(pairs.size());
  for (uint32_t place = 0; place < pairs.size(); ++place) links.place[links.link_packets.tree.order[place]] = place;
  return links;
}

}  // namespace nlg
