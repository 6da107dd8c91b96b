// Boxes of the ball's centre are halved until the distance from a box's middle to the nearest face decides: distance changes by no
// more than the middle moves. Winding number: A. van Oosterom and J. Strackee, The solid angle of a plane triangle, 1983.
#include "scene/solid/inscribed_ball.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "scene/solid/triangle_distance.h"

namespace nlg {
namespace {

constexpr float kFineness = 0.0625f;  // of the radius, from a box's middle to its corners: smaller ones are not looked at

enum class Side : uint8_t { unknown, inside };

class BallSearch {
 public:
  BallSearch(const std::vector<Facet>& faces, float radius_m, uint64_t* cost_left)
      : faces_(faces), radius_m_(radius_m), cost_left_(cost_left) {}

  bool isOutOfCost() const { return is_out_of_cost_; }

  // near   faces, of which those are left out that bound no ball whose middle is in the box
  bool holdsMiddle(const glm::vec3& low, const glm::vec3& high, const std::vector<uint32_t>& near, Side side) {
    if (!pay(near.size())) return false;
    const glm::vec3 middle = 0.5f * (low + high);
    const float reach_m = glm::distance(middle, high);
    float nearest_m = radius_m_ + reach_m;
    std::vector<uint32_t> nearer;
    for (const uint32_t i : near) {
      const float distance_m = distanceToTriangle(middle, faces_[i][0], faces_[i][1], faces_[i][2]);
      if (distance_m < radius_m_ + reach_m) nearer.push_back(i);
      nearest_m = std::min(nearest_m, distance_m);
    }
    if (nearest_m + reach_m < radius_m_) return false;
    // a box that no face meets is inside or outside as a whole
    if (side == Side::unknown && nearest_m >= std::min(radius_m_, reach_m)) {
      if (isInside(middle))
        side = Side::inside;
      else if (nearest_m >= reach_m)
        return false;
    }
    if (side == Side::inside && nearest_m >= radius_m_) return true;
    if (reach_m < kFineness * radius_m_) return false;
    const Side of_halves = nearest_m >= reach_m ? side : Side::unknown;
    const glm::vec3 size = high - low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    glm::vec3 end = high, start = low;
    end[axis] = start[axis] = middle[axis];
    return holdsMiddle(low, end, nearer, of_halves) || holdsMiddle(start, high, nearer, of_halves);
  }

 private:
  bool pay(uint64_t cost) {
    is_out_of_cost_ |= cost > *cost_left_;
    *cost_left_ -= std::min(cost, *cost_left_);
    return !is_out_of_cost_;
  }

  bool isInside(const glm::vec3& point) {
    if (!pay(faces_.size())) return false;
    double sum = 0.0;
    for (const Facet& face : faces_) {
      const glm::vec3 a = face[0] - point, b = face[1] - point, c = face[2] - point;
      const float of_a = glm::length(a), of_b = glm::length(b), of_c = glm::length(c);
      sum += std::atan2(glm::dot(a, glm::cross(b, c)),
                        of_a * of_b * of_c + glm::dot(a, b) * of_c + glm::dot(b, c) * of_a + glm::dot(c, a) * of_b);
    }
    return sum > std::acos(-1.0);  // half of what a point inside sees: each angle is twice what was added
  }

  const std::vector<Facet>& faces_;
  const float radius_m_;
  uint64_t* cost_left_;
  bool is_out_of_cost_ = false;
};

}  // namespace

std::optional<bool> ballFits(const std::vector<Facet>& faces, double diameter_m, uint64_t* cost_left) {
  if (faces.empty()) return false;
  const auto radius_m = static_cast<float>(0.5 * diameter_m);
  glm::vec3 low = faces[0][0], high = low;
  for (const Facet& face : faces) {
    for (const glm::vec3& corner : face) low = glm::min(low, corner), high = glm::max(high, corner);
  }
  // no middle is nearer to a side of the box around all
  low += radius_m;
  high -= radius_m;
  if (glm::any(glm::greaterThan(low, high))) return false;
  std::vector<uint32_t> all(faces.size());
  std::iota(all.begin(), all.end(), 0u);
  BallSearch search(faces, radius_m, cost_left);
  const bool is_found = search.holdsMiddle(low, high, all, Side::unknown);
  if (search.isOutOfCost()) return std::nullopt;
  return is_found;
}

}  // namespace nlg
