#include "validate/look_up/places.h"

#include <algorithm>
#include <cmath>

#include "datagen/visibility/triangle_distance.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

class DistanceClasses {
 public:
  explicit DistanceClasses(const RayScene& rays) : rays_(rays) {}

  uint8_t of(const glm::vec3& place) {
    const auto reach_m = static_cast<float>(kDistanceBordersM.back());
    rays_.trianglesNearCube(place, reach_m, &near_);
    float distance_m = reach_m;
    for (const uint32_t triangle : near_) {
      const glm::uvec3& corners = rays_.triangles()[triangle];
      const auto& position = rays_.positions();
      distance_m = std::min(distance_m, distanceToTriangle(place, position[corners.x], position[corners.y], position[corners.z]));
    }
    const auto border = std::upper_bound(kDistanceBordersM.begin(), kDistanceBordersM.end(), double{distance_m});
    return static_cast<uint8_t>(border - kDistanceBordersM.begin());
  }

 private:
  const RayScene& rays_;
  std::vector<uint32_t> near_;
};

}  // namespace

std::vector<glm::dvec3> Places::positions() const {
  std::vector<glm::dvec3> all;
  for (const Place& place : places) all.push_back(place.position_m);
  return all;
}

double Places::weight(uint8_t distance_class) const {
  return kept[distance_class] > 0 ? air_share[distance_class] / static_cast<double>(kept[distance_class]) : 0.0;
}

Places drawPlaces(const ExtentBox& extent, const RayScene& rays, const SupportVisibility& visibility, const ProbeTree& tree,
                  const PlaceOptions& options) {
  Places result;
  DistanceClasses classes(rays);
  Random random(options.seed);
  std::array<uint64_t, kDistanceClassCount> in_class{};  // of those that say shares
  const uint64_t wanted = std::max<uint64_t>(1, options.places / kDistanceClassCount);
  const auto isFull = [&](size_t c) { return result.kept[c] >= wanted; };
  for (uint64_t draw = 0; draw < std::max(options.draws, options.share_draws); ++draw) {
    const bool says_shares = draw < options.share_draws;
    // classes that no place has been found in yet are not waited for
    const auto isDone = [&](size_t c) { return isFull(c) || in_class[c] == 0; };
    if (!says_shares && isDone(0) && isDone(1) && isDone(2) && isDone(3)) break;
    glm::dvec3 position;
    for (int axis = 0; axis < 3; ++axis) position[axis] = random.uniform(extent.low_m[axis], extent.high_m[axis]);
    const uint8_t distance_class = classes.of(glm::vec3(position));
    if (!says_shares && isFull(distance_class)) continue;
    const SolidVote vote = visibility.voteAt(position);
    const bool in_air = !vote.solid() && !vote.disputed();
    ProbesAround around;
    const bool in_tree = tree.lookUp({position.x, position.y, position.z}, &around);
    if (says_shares) {
      ++result.drawn;
      result.in_solid += vote.solid();
      result.disputed += vote.disputed();
      result.in_air += in_air;
      result.outside += in_air && !in_tree;
      in_class[distance_class] += in_air && in_tree;
    }
    if (!in_air || !in_tree || isFull(distance_class)) continue;
    ++result.kept[distance_class];
    result.places.push_back({position, distance_class});
  }
  const double in_tree = static_cast<double>(result.in_air - result.outside);
  for (size_t c = 0; c < kDistanceClassCount && in_tree > 0.0; ++c)
    result.air_share[c] = static_cast<double>(in_class[c]) / in_tree;
  return result;
}

}  // namespace nlg
