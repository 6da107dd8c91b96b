#include "scene/obj/polygon_cut.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

namespace nlg {
namespace {

// Of the polygon's area, and of the square of its extent: what sums of doubles lose.
constexpr double kAreaTolerance = 1e-6, kExtentTolerance = 1e-9;

// The corners that are left, as a k-d tree.
class CornerTree {
 public:
  static constexpr size_t kLeaf = 8;
  struct Box {
    glm::dvec2 low, high;
  };

  explicit CornerTree(const std::vector<glm::dvec2>& corners) : corners_(corners), order_(corners.size()), rank_(corners.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    build(0, 0, order_.size());
    for (size_t i = 0; i < order_.size(); ++i) rank_[order_[i]] = i;
  }

  void remove(uint32_t corner) {
    size_t node = 0, first = 0, end = order_.size();
    for (--nodes_[0].left; end - first > kLeaf; --nodes_[node].left) {
      const size_t middle = (first + end) / 2;
      const bool is_behind = rank_[corner] >= middle;
      node = 2 * node + (is_behind ? 2 : 1);
      (is_behind ? first : end) = middle;
    }
    std::swap(order_[rank_[corner]], order_[first + nodes_[node].left]);
    std::swap(rank_[corner], rank_[order_[rank_[corner]]]);
  }

  // Whether `holds` of any; only those in boxes that it may hold of are asked.
  template <class MayHold, class Holds>
  bool any(const MayHold& may_hold, const Holds& holds) const {
    return any(may_hold, holds, 0, 0, order_.size());
  }

 private:
  struct Node {
    Box box;
    size_t left = 0;  // of its corners; in a leaf the first ones
  };

  void build(size_t node, size_t first, size_t end) {
    if (nodes_.size() <= node) nodes_.resize(node + 1);
    Box box = {corners_[order_[first]], corners_[order_[first]]};
    for (size_t i = first; i < end; ++i) box = {glm::min(box.low, corners_[order_[i]]), glm::max(box.high, corners_[order_[i]])};
    nodes_[node] = {box, end - first};
    if (end - first <= kLeaf) return;
    const glm::dvec2 size = box.high - box.low;
    const int axis = size.x >= size.y ? 0 : 1;
    const size_t middle = (first + end) / 2;
    const auto at = [&](size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(first), at(middle), at(end),
                     [&](uint32_t a, uint32_t b) { return corners_[a][axis] < corners_[b][axis]; });
    build(2 * node + 1, first, middle);
    build(2 * node + 2, middle, end);
  }

  template <class MayHold, class Holds>
  bool any(const MayHold& may_hold, const Holds& holds, size_t node, size_t first, size_t end) const {
    if (nodes_[node].left == 0 || !may_hold(nodes_[node].box)) return false;
    if (end - first <= kLeaf) {
      const auto begin = order_.begin() + static_cast<std::ptrdiff_t>(first);
      return std::any_of(begin, begin + static_cast<std::ptrdiff_t>(nodes_[node].left), holds);
    }
    const size_t middle = (first + end) / 2;
    return any(may_hold, holds, 2 * node + 1, first, middle) || any(may_hold, holds, 2 * node + 2, middle, end);
  }

  const std::vector<glm::dvec2>& corners_;
  std::vector<uint32_t> order_;
  std::vector<size_t> rank_;  // of each in order_
  std::vector<Node> nodes_;   // the children of i are 2 i + 1 and 2 i + 2
};

class EarCutter {
 public:
  explicit EarCutter(const std::vector<glm::dvec3>& corners) {
    const glm::dvec3 first = corners[0];
    glm::dvec3 normal(0.0);
    for (size_t i = 1; i + 1 < corners.size(); ++i) {
      const glm::dvec3 part = glm::cross(corners[i] - first, corners[i + 1] - first);
      normal += part;
      largest_ = std::max(largest_, glm::length(part));
    }
    const glm::dvec3 facing = glm::abs(normal);
    const int axis = facing.x >= facing.y && facing.x >= facing.z ? 0 : facing.y >= facing.z ? 1 : 2;
    int u = (axis + 1) % 3, v = (axis + 2) % 3;
    if (normal[axis] < 0.0) std::swap(u, v);
    twice_area_ = facing[axis];
    const auto count = static_cast<uint32_t>(corners.size());
    for (uint32_t i = 0; i < count; ++i) {
      flat_.emplace_back(corners[i][u] - first[u], corners[i][v] - first[v]);
      next_.push_back((i + 1) % count);
      before_.push_back((i + count - 1) % count);
      extent_ = std::max({extent_, std::abs(flat_[i].x), std::abs(flat_[i].y)});
    }
    if (count > CornerTree::kLeaf) tree_.emplace(flat_);
  }

  PolygonCut cut() {
    size_t left = flat_.size(), tries = 0, asked = 0;
    const size_t most_asked = std::min<size_t>(128 * left, 1 << 17);  // of isEar: a hostile outline is cut somehow
    uint32_t i = left == 4 && glm::distance(flat_[0], flat_[2]) < glm::distance(flat_[1], flat_[3]) ? 1 : 0;
    while (left >= 3) {
      const bool may_ask = left > 3 && tries < left && asked < most_asked;
      asked += may_ask && turn(i) > 0.0 ? 1 : 0;
      if (may_ask && !isEar(i)) {
        i = next_[i];
        ++tries;
        continue;
      }
      if (!may_ask && left > 3) i = flattest(i);
      const double twice_area = turn(i);
      covered_ += std::abs(twice_area);
      std::array<uint32_t, 3> corners = {before_[i], i, next_[i]};
      std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
      if (twice_area != 0.0) result_.triangles.emplace_back(corners[0], corners[1], corners[2]);
      if (tree_) tree_->remove(i);
      next_[before_[i]] = next_[i];
      before_[next_[i]] = before_[i];
      // every other corner: a fan around one has slivers
      i = next_[next_[i]];
      tries = 0;
      --left;
    }
    const double tolerance = kAreaTolerance * twice_area_ + kExtentTolerance * extent_ * extent_;
    // two halves of a bow leave nothing to look along
    const bool is_bow = twice_area_ < 1e-6 * largest_;
    result_.holds_area = std::abs(covered_ - twice_area_) <= tolerance && !is_bow;
    return std::move(result_);
  }

 private:
  // Twice the area of a triangle, positive where it is counter-clockwise.
  double turn(uint32_t a, uint32_t b, const glm::dvec2& c) const {
    const glm::dvec2 ab = flat_[b] - flat_[a], ac = c - flat_[a];
    return ab.x * ac.y - ab.y * ac.x;
  }
  double turn(uint32_t a, uint32_t b, uint32_t c) const { return turn(a, b, flat_[c]); }
  double turn(uint32_t i) const { return turn(before_[i], i, next_[i]); }

  // Where corners fall together, as those of a line to a hole do, only what enters the triangle there is in its way.
  bool isEar(uint32_t b) const {
    const uint32_t a = before_[b], c = next_[b];
    if (!(turn(b) > 0.0)) return false;
    const auto enters = [&](uint32_t i) { return turn(a, b, i) > 0.0 && turn(b, c, i) > 0.0; };
    const auto is_in_way = [&](uint32_t i) {
      if (i == b || flat_[i] == flat_[a] || flat_[i] == flat_[c]) return false;
      return flat_[i] == flat_[b] ? enters(before_[i]) || enters(next_[i])
                                  : turn(a, b, i) >= 0.0 && turn(b, c, i) >= 0.0 && turn(c, a, i) >= 0.0;
    };
    // rounding keeps order: of no corner of a box a turn is larger than at the box's own corner farthest to the left
    const auto reaches = [&](const CornerTree::Box& box, uint32_t from, uint32_t to) {
      const glm::dvec2 way = flat_[to] - flat_[from];
      return turn(from, to, glm::dvec2(way.y > 0.0 ? box.low.x : box.high.x, way.x > 0.0 ? box.high.y : box.low.y)) >= 0.0;
    };
    const auto may_be_in_way = [&](const CornerTree::Box& box) {
      if (box.low == box.high && (box.low == flat_[a] || box.low == flat_[c])) return false;
      const bool holds_b = glm::all(glm::lessThanEqual(box.low, flat_[b])) && glm::all(glm::lessThanEqual(flat_[b], box.high));
      return holds_b || (reaches(box, a, b) && reaches(box, b, c) && reaches(box, c, a));
    };
    if (tree_) return !tree_->any(may_be_in_way, is_in_way);
    for (uint32_t i = next_[c]; i != a; i = next_[i]) {
      if (is_in_way(i)) return false;
    }
    return true;
  }

  // Where no corner is an ear all lie on a line, or the outline crosses itself.
  uint32_t flattest(uint32_t first) const {
    uint32_t best = first;
    for (uint32_t i = next_[first]; i != first; i = next_[i]) best = std::abs(turn(i)) < std::abs(turn(best)) ? i : best;
    return best;
  }

  std::vector<glm::dvec2> flat_;         // relative to the first corner; counter-clockwise
  std::vector<uint32_t> next_, before_;  // of those that are left
  std::optional<CornerTree> tree_;       // of these; none where they are few
  double twice_area_ = 0.0, covered_ = 0.0, extent_ = 0.0, largest_ = 0.0;
  PolygonCut result_;
};

}  // namespace

PolygonCut cutPolygon(const std::vector<glm::dvec3>& corners) {
  return corners.size() == 3 ? PolygonCut{{{0, 1, 2}}, true} : EarCutter(corners).cut();
}

}  // namespace nlg
