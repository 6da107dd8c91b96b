#include "datagen/visibility/cavity.h"

#include <cmath>

#include "datagen/visibility/air_regions.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

constexpr uint64_t kWalkStream = 0x63617669747900;
constexpr int kWalks = 12;
constexpr int kWaysOut = 3;      // so many of the walks come out of what is open
constexpr int kSteps = 16;       // of a walk
constexpr int kLooksOfStep = 4;  // of a step: half of them anywhere, half of them onward

// One walk, in gaps too narrow for a region: of a few points in sight to the one that is farthest from `fled`, and so on, until one lies
// in wide air or in a region, or a ray meets nothing.
// fled   where the last walk ended, for it to go another way; in the end, where this one did
bool comesOut(const RayScene& rays, glm::vec3 at, float radius_m, glm::vec3* fled, Random& random) {
  const glm::vec3 from = *fled;
  for (int step = 0; step < kSteps; ++step) {
    const std::optional<bool> is_closed = step > 0 ? rays.airRegions().isClosedAround(at) : std::nullopt;
    if (is_closed.has_value()) {
      *fled = at;
      return !*is_closed;
    }
    float farthest_m = -1.0f;
    glm::vec3 next = at;
    const float gone_m = glm::distance(at, from);
    for (int look = 0; look < kLooksOfStep; ++look) {
      glm::vec3 direction = randomDirection(random);
      // along a duct nearly all random rays are short
      if (look % 2 == 1 && gone_m > 0.0f) direction = glm::normalize((at - from) / gone_m + 0.3f * direction);
      const LightHit hit = rays.lightHit(at, direction);
      if (hit.kind != LightHit::Kind::surface) return true;
      const glm::vec3 seen = at + direction * hit.distance * static_cast<float>(random.uniform(0.4, 0.95));
      // a ball that is free holds half its width of any ray that comes through its middle
      if (hit.distance >= radius_m && rays.isFree(seen, radius_m)) return true;
      if (const float distance_m = glm::distance(from, seen); distance_m > farthest_m) {
        farthest_m = distance_m;
        next = seen;
      }
    }
    at = next;
  }
  *fled = at;
  return false;
}

}  // namespace

bool isInCavity(const RayScene& rays, const glm::dvec3& position_m) {
  const auto radius_m = static_cast<float>(0.5 * rays.cavityWidth());
  const glm::vec3 place(position_m);
  if (!(radius_m > 0.0f) || rays.isFree(place, radius_m)) return false;
  if (const std::optional<bool> is_closed = rays.airRegions().isClosedAround(place)) return *is_closed;
  Random random(kWalkStream);
  glm::vec3 fled = place;
  int out = 0;
  for (int walk = 0; walk < kWalks && out + kWalks - walk >= kWaysOut; ++walk) {
    out += comesOut(rays, place, radius_m, &fled, random);
    if (out == kWaysOut) return false;
  }
  return true;
}

}  // namespace nlg
