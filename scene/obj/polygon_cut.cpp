#include "scene/obj/polygon_cut.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace nlg {
namespace {

// Of the polygon's area, and of the square of its extent: what sums of doubles lose.
constexpr double kAreaTolerance = 1e-6, kExtentTolerance = 1e-9;

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
  double turn(uint32_t a, uint32_t b, uint32_t c) const {
    const glm::dvec2 ab = flat_[b] - flat_[a], ac = flat_[c] - flat_[a];
    return ab.x * ac.y - ab.y * ac.x;
  }
  double turn(uint32_t i) const { return turn(before_[i], i, next_[i]); }

  // Where corners fall together, as those of a line to a hole do, only what enters the triangle there is in its way.
  bool isEar(uint32_t b) const {
    const uint32_t a = before_[b], c = next_[b];
    if (!(turn(b) > 0.0)) return false;
    const auto enters = [&](uint32_t i) { return turn(a, b, i) > 0.0 && turn(b, c, i) > 0.0; };
    for (uint32_t i = next_[c]; i != a; i = next_[i]) {
      if (flat_[i] == flat_[a] || flat_[i] == flat_[c]) continue;
      const bool is_in_way = flat_[i] == flat_[b] ? enters(before_[i]) || enters(next_[i])
                                                  : turn(a, b, i) >= 0.0 && turn(b, c, i) >= 0.0 && turn(c, a, i) >= 0.0;
      if (is_in_way) return false;
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
  double twice_area_ = 0.0, covered_ = 0.0, extent_ = 0.0, largest_ = 0.0;
  PolygonCut result_;
};

}  // namespace

PolygonCut cutPolygon(const std::vector<glm::dvec3>& corners) {
  return corners.size() == 3 ? PolygonCut{{{0, 1, 2}}, true} : EarCutter(corners).cut();
}

}  // namespace nlg
