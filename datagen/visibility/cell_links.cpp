#include "datagen/visibility/cell_links.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "tool/error.h"

namespace nlg {
namespace {

using Away = std::array<int8_t, 3>;
using Place = std::array<int32_t, 3>;  // in units of 2^-16 spacings: exact

constexpr int32_t kUnit = 1 << 16;
constexpr int32_t kMostApart = kUnit / 4;  // of a point and its 32 nearest

Place placeOf(size_t point) {
  Place place;
  for (int axis = 0; axis < 3; ++axis) place[axis] = static_cast<int32_t>(cellPoint(point)[axis] * kUnit);
  return place;
}

struct Neighbour {
  int64_t squared_distance;
  Away away;
  uint16_t point;
};

// A link as its lower cell has it.
struct Link {
  uint16_t from;
  Away away;
  uint16_t to;
  auto operator<=>(const Link&) const = default;
};

Away opposite(const Away& away) {
  return {static_cast<int8_t>(-away[0]), static_cast<int8_t>(-away[1]), static_cast<int8_t>(-away[2])};
}

Link linkOf(uint16_t from, const Neighbour& to) {
  const auto& [x, y, z] = to.away;
  const bool is_of_other = std::tuple(z, y, x, from) < std::tuple<int8_t, int8_t, int8_t, uint16_t>(0, 0, 0, to.point);
  return is_of_other ? Link{to.point, opposite(to.away), from} : Link{from, to.away, to.point};
}

std::vector<Neighbour> nearestOf(size_t point) {
  const Place from = placeOf(point);
  std::vector<Neighbour> found;
  for (uint16_t other = 0; other < kOctantPointCount; ++other) {
    // its nearest image along each axis
    Neighbour neighbour{0, {}, other};
    const Place to = placeOf(other);
    for (int axis = 0; axis < 3; ++axis) {
      int64_t apart = to[axis] - from[axis];
      if (std::abs(apart) > kUnit / 2) {
        neighbour.away[axis] = apart > 0 ? -1 : 1;
        apart += int64_t{neighbour.away[axis]} * kUnit;
      }
      neighbour.squared_distance += apart * apart;
    }
    if (other != point) found.push_back(neighbour);
  }
  std::partial_sort(found.begin(), found.begin() + kLinkCount, found.end(), [](const Neighbour& a, const Neighbour& b) {
    return std::tie(a.squared_distance, a.point) < std::tie(b.squared_distance, b.point);
  });
  found.resize(kLinkCount);
  NLG_CHECK(found.back().squared_distance, <, int64_t{kMostApart} * kMostApart);
  return found;
}

class CellLinksBuilder {
 public:
  CellLinks build() {
    findImages();
    findNeighbours();
    packLinks();
    listInnerEdges();
    return std::move(links_);
  }

 private:
  // The pattern is closed under mirrors of the cell.
  void findImages() {
    std::map<Place, uint16_t> point_at;
    for (uint16_t point = 0; point < kOctantPointCount; ++point) point_at[placeOf(point)] = point;
    for (int corner = 0; corner < kCellCorners; ++corner) {
      for (size_t point = 0; point < kOctantPointCount; ++point) {
        Place image = placeOf(point);
        for (int axis = 0; axis < 3; ++axis) image[axis] = corner >> axis & 1 ? kUnit - image[axis] : image[axis];
        links_.point_of[corner][point] = point_at.at(image);
      }
    }
  }

  // Of one of eight images, and copied, so that sums over neighbours are those of mirrored scenes bit by bit.
  void findNeighbours() {
    neighbours_.resize(kOctantPointCount);
    for (uint16_t point = 0; point < kOctantPointCount; ++point) {
      if (!neighbours_[point].empty()) continue;
      const std::vector<Neighbour> own = nearestOf(point);
      for (int corner = 0; corner < kCellCorners; ++corner) {
        std::vector<Neighbour>& images = neighbours_[links_.point_of[corner][point]];
        images = own;
        for (Neighbour& image : images) {
          image.point = links_.point_of[corner][image.point];
          for (int axis = 0; axis < 3; ++axis)
            image.away[axis] = static_cast<int8_t>(corner >> axis & 1 ? -image.away[axis] : image.away[axis]);
        }
      }
    }
  }

  // The number of a place that links end at, in the frame of packets.
  uint64_t endAt(const Away& away, uint16_t point) {
    const auto [found, is_new] = end_of_.try_emplace({away, point}, ends_.size());
    if (is_new) {
      LocalPoint& end = ends_.emplace_back();
      for (int axis = 0; axis < 3; ++axis)
        end[axis] = static_cast<float>((double{cellPoint(point)[axis]} + away[axis] - 0.5) / kCellReach);
    }
    return found->second;
  }

  void packLinks() {
    for (uint16_t point = 0; point < kOctantPointCount; ++point) {
      for (const Neighbour& neighbour : neighbours_[point]) place_of_.emplace(linkOf(point, neighbour), 0);
    }
    std::vector<uint64_t> pairs;
    std::vector<uint16_t*> places;
    for (auto& [link, place] : place_of_) {
      pairs.push_back(endAt({}, link.from) << 32 | endAt(link.away, link.to));
      places.push_back(&place);
    }
    links_.packets = makeLinkPackets(ends_, pairs);
    for (size_t place = 0; place < pairs.size(); ++place)
      *places[links_.packets.tree.order[place]] = static_cast<uint16_t>(place);
    for (uint16_t point = 0; point < kOctantPointCount; ++point) {
      for (const Neighbour& neighbour : neighbours_[point]) {
        const Link link = linkOf(point, neighbour);
        const bool is_theirs = neighbour.away != Away{} && link.away != neighbour.away;
        links_.nearest.push_back({neighbour.point, place_of_.at(link), neighbour.away, is_theirs});
        links_.distance.push_back(static_cast<float>(std::sqrt(static_cast<double>(neighbour.squared_distance)) / kUnit));
      }
    }
  }

  // A link carries if it is among the 16 nearest of either end.
  void listInnerEdges() {
    std::vector<std::map<uint16_t, uint16_t>> edges(kOctantPointCount);  // other end, link
    for (size_t entry = 0; entry < links_.nearest.size(); ++entry) {
      const CellLinks::Edge& edge = links_.nearest[entry];
      if (entry % kLinkCount >= kCarryingLinkCount || edge.away != Away{}) continue;
      const auto point = static_cast<uint16_t>(entry / kLinkCount);
      edges[point][edge.point] = edges[edge.point][point] = edge.link;
    }
    for (const auto& of_point : edges) {
      links_.first_inner.push_back(static_cast<uint32_t>(links_.inner.size()));
      for (const auto& [point, link] : of_point) links_.inner.push_back({point, link});
    }
    links_.first_inner.push_back(static_cast<uint32_t>(links_.inner.size()));
  }

  CellLinks links_;
  std::vector<std::vector<Neighbour>> neighbours_;
  std::map<Link, uint16_t> place_of_;
  std::map<std::pair<Away, uint16_t>, uint64_t> end_of_;
  std::vector<LocalPoint> ends_;
};

}  // namespace

const CellPoints& CellPoints::all() {
  static const CellPoints points = [] {
    CellPoints every;
    every.words.fill(~uint64_t{0});
    return every;
  }();
  return points;
}

const CellPoints& CellPoints::none() {
  static const CellPoints points;
  return points;
}

void CellPoints::operator|=(const CellPoints& other) {
  for (size_t w = 0; w < words.size(); ++w) words[w] |= other.words[w];
}

void CellPoints::operator&=(const CellPoints& other) {
  for (size_t w = 0; w < words.size(); ++w) words[w] &= other.words[w];
}

const LocalPoint& cellPoint(size_t point) { return supportPattern().points[point]; }

const CellLinks& cellLinks() {
  static const CellLinks links = CellLinksBuilder().build();
  return links;
}

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
