#include "datagen/visibility/air_regions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <mutex>
#include <queue>
#include <utility>

#include "datagen/visibility/ray_scene.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

constexpr float kStepsPerWidth = 4.0f, kMostSteps = 0x1p20f;  // the latter along the scene's longest side
// Walls stand at round numbers, and the lattice's points do not.
constexpr glm::vec3 kShift(0.3819660f, 0.2763932f, 0.4472136f);
// From a way's line to the one beside it, in steps, a fiftieth of the width: both are open, so that narrower cracks lead nowhere.
constexpr glm::vec3 kAside(0.05f, 0.047f, 0.053f);
// Looks out of a region, from each of its points: one and more, until there are so many in all, at most 64.
constexpr int kLooks = 64, kLooksOfRegion = 2048;
constexpr int kLooksOfCrack = 200;  // where fewer than one of so many see open air, a region is closed all the same
constexpr uint64_t kLookStream = 0x6c6f6f6b73;
constexpr size_t kMostPoints = size_t{1} << 20;  // of a region
constexpr size_t kMostKnown = size_t{1} << 24;   // kept in memory

}  // namespace

glm::vec3 randomDirection(Random& random) {
  for (;;) {
    const auto x = static_cast<float>(random.uniform(-1.0, 1.0)), y = static_cast<float>(random.uniform(-1.0, 1.0)),
               z = static_cast<float>(random.uniform(-1.0, 1.0));
    const glm::vec3 direction(x, y, z);
    const float square = glm::dot(direction, direction);
    if (square > 1e-4f && square <= 1.0f) return direction / std::sqrt(square);
  }
}

size_t AirRegions::Hash::operator()(const glm::ivec3& point) const { return mixSeed(point.x, point.y, point.z); }

AirRegions::AirRegions(const RayScene& rays, float width_m, const glm::vec3& low, const glm::vec3& high)
    : rays_(rays),
      radius_m_(0.5f * width_m),
      step_m_(std::max({width_m / kStepsPerWidth, (high.x - low.x) / kMostSteps, (high.y - low.y) / kMostSteps,
                        (high.z - low.z) / kMostSteps})),
      low_(low),
      high_(high) {}

glm::vec3 AirRegions::positionOf(const glm::ivec3& point) const { return low_ + step_m_ * (glm::vec3(point) + kShift); }

bool AirRegions::isOpenWay(const glm::vec3& from, const glm::vec3& to) const {
  const glm::vec3 aside = step_m_ * kAside;
  return !rays_.isOpaqueBetween(from, to) &&
         (!rays_.isOpaqueBetween(from + aside, to + aside) || !rays_.isOpaqueBetween(from - aside, to - aside));
}

bool AirRegions::isLinked(const glm::ivec3& a, const glm::ivec3& b) const {
  // from the same end, whoever asks
  return isOpenWay(positionOf(glm::min(a, b)), positionOf(glm::max(a, b)));
}

float AirRegions::clearanceAt(const glm::ivec3& point) const {
  const glm::vec3 at = positionOf(point);
  const bool is_past = glm::any(glm::lessThan(at, low_)) || glm::any(glm::greaterThan(at, high_));
  return is_past ? radius_m_ : rays_.clearance(at, radius_m_);
}

std::optional<bool> AirRegions::known(const glm::ivec3& point) const {
  const std::shared_lock lock(mutex_);
  const auto found = known_.find(point);
  return found == known_.end() ? std::nullopt : std::optional(found->second);
}

bool AirRegions::spread(const glm::ivec3& start, Points* points) const {
  // towards what is wide first: beside a room's wall it is two steps away
  struct Reached {
    float clearance_m;
    glm::ivec3 point;
    bool operator<(const Reached& other) const { return clearance_m < other.clearance_m; }
  };
  points->insert(start);
  std::priority_queue<Reached> next;
  next.push({clearanceAt(start), start});
  if (next.top().clearance_m >= radius_m_) return true;
  while (!next.empty()) {
    const glm::ivec3 point = next.top().point;
    next.pop();
    for (int side = 0; side < 6; ++side) {
      glm::ivec3 neighbour = point;
      neighbour[side / 2] += side % 2 == 0 ? 1 : -1;
      if (points->count(neighbour) > 0 || !isLinked(point, neighbour)) continue;
      points->insert(neighbour);
      const float clearance_m = clearanceAt(neighbour);
      // a closed region that another thread has just remembered is looked through all the same
      if (clearance_m >= radius_m_ || points->size() > kMostPoints || known(neighbour) == std::optional(false)) return true;
      next.push({clearance_m, neighbour});
    }
  }
  return false;
}

AirRegions::Sight AirRegions::look(const glm::ivec3& point, Random& random) const {
  const glm::vec3 from = positionOf(point), direction = randomDirection(random);
  const auto share = static_cast<float>(random.uniform(0.4, 0.95));
  const LightHit hit = rays_.lightHit(from, direction);
  const bool is_out = hit.kind != LightHit::Kind::surface;
  const float distance_m = !is_out                           ? share * hit.distance
                           : hit.kind == LightHit::Kind::sky ? hit.distance
                                                             : glm::distance(low_, high_);
  const glm::vec3 to = from + distance_m * direction;
  if (!isOpenWay(from, to)) return {};
  if (is_out || rays_.isFree(to, radius_m_)) return {true, {}};
  return {false, nearestSeen(to)};
}

// Regions that no link leads out of.
struct AirRegions::Enclosed {
  struct Region {
    Points points;
    int look_count = 0, out_count = 0;  // of looks: all of them, and those that see open air
    std::vector<size_t> seen;           // others, once for each look

    bool isOpen() const { return out_count > 0 && kLooksOfCrack * out_count >= look_count; }
  };
  std::deque<Region> regions;
  std::unordered_map<glm::ivec3, size_t, Hash> region_of;
};

// What is known of a point's region. Nothing where looks have to judge it: then it is among the enclosed ones.
std::optional<bool> AirRegions::judge(const glm::ivec3& point, Enclosed* enclosed) const {
  if (const std::optional<bool> answer = known(point)) return answer;
  if (enclosed->region_of.count(point) > 0) return std::nullopt;
  Points points;
  if (spread(point, &points)) {
    remember(points, false);
    return false;
  }
  for (const glm::ivec3& member : points) enclosed->region_of.emplace(member, enclosed->regions.size());
  enclosed->regions.emplace_back().points = std::move(points);
  return std::nullopt;
}

void AirRegions::lookAround(size_t region_idx, Enclosed* enclosed) const {
  Enclosed::Region& region = enclosed->regions[region_idx];
  const auto size = static_cast<int>(region.points.size());
  const int look_count = std::clamp(kLooksOfRegion / size, 1, kLooks);
  region.look_count = size * look_count;
  for (const glm::ivec3& point : region.points) {
    Random random(mixSeed(kLookStream, point.x, point.y, point.z));
    for (int i = 0; i < look_count && !region.isOpen(); ++i) {
      const Sight sight = look(point, random);
      region.out_count += sight.is_wide;
      if (!sight.point) continue;
      const std::optional<bool> is_closed = judge(*sight.point, enclosed);
      if (!is_closed)
        region.seen.push_back(enclosed->region_of.at(*sight.point));
      else
        region.out_count += !*is_closed;
    }
  }
}

bool AirRegions::isClosed(const glm::ivec3& start) const {
  Enclosed enclosed;
  if (const std::optional<bool> answer = judge(start, &enclosed)) return *answer;
  std::deque<Enclosed::Region>& regions = enclosed.regions;
  for (size_t i = 0; i < regions.size() && !regions[0].isOpen(); ++i) lookAround(i, &enclosed);
  // from those that see open air to those that see them
  std::vector<char> is_open(regions.size(), 0);
  for (bool is_new = true; is_new;) {
    is_new = false;
    for (size_t i = 0; i < regions.size(); ++i) {
      if (is_open[i] || !regions[i].isOpen()) continue;
      is_open[i] = is_new = true;
      for (Enclosed::Region& other : regions)
        other.out_count += static_cast<int>(std::count(other.seen.begin(), other.seen.end(), i));
    }
  }
  // where the first one was open without them, nothing is known of the others
  const size_t judged = is_open[0] ? 1 : regions.size();
  for (size_t i = 0; i < judged; ++i) remember(regions[i].points, !is_open[i]);
  return !is_open[0];
}

void AirRegions::remember(const Points& points, bool is_closed) const {
  const std::unique_lock lock(mutex_);
  if (known_.size() + points.size() > kMostKnown) return;
  for (const glm::ivec3& point : points) known_.emplace(point, is_closed);
}

std::optional<glm::ivec3> AirRegions::nearestSeen(const glm::vec3& place) const {
  const glm::ivec3 cell(glm::floor((place - low_) / step_m_ - kShift));
  std::array<std::pair<float, glm::ivec3>, 8> corners;
  for (int k = 0; k < 8; ++k) {
    const glm::ivec3 corner = cell + glm::ivec3(k & 1, k >> 1 & 1, k >> 2);
    corners[k] = {glm::distance(positionOf(corner), place), corner};
  }
  std::sort(corners.begin(), corners.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [unused, corner] : corners) {
    if (isOpenWay(place, positionOf(corner))) return corner;
  }
  return std::nullopt;
}

std::optional<bool> AirRegions::isClosedAround(const glm::vec3& place) const {
  const std::optional<glm::ivec3> nearest = nearestSeen(place);
  return nearest ? std::optional(isClosed(*nearest)) : std::nullopt;
}

}  // namespace nlg
