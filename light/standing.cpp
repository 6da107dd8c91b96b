#include "light/standing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "light/air.h"

namespace nlg {
namespace {

constexpr float kWalkableSlope = 0.7f;                  // of the floor's normal: 45 degrees, as games have it
constexpr double kUprightM = kEyeHeightM + kOverEyesM;  // below it nobody stands upright
constexpr double kLeastHeadroomM = 0.5;                 // below it nobody looks out
constexpr double kElbowRoomM = 0.25;                    // around an eye
constexpr double kStrideM = 0.6, kStepM = 0.3;          // around a place to stand: no table, no ledge
constexpr int kTurns = 8;                               // around the vertical

glm::dvec3 around(int turn) {
  const double angle = 2.0 * std::numbers::pi * turn / kTurns;
  return {std::cos(angle), 0.0, std::sin(angle)};
}

}  // namespace

bool Spots::isInExtent(const glm::dvec3& place_m) const {
  return glm::all(glm::greaterThanEqual(place_m, extent_.low_m)) && glm::all(glm::lessThanEqual(place_m, extent_.high_m));
}

std::optional<Spot> Spots::below(const glm::dvec3& place_m) const {
  const LightHit floor = rays_.lightHit(glm::vec3(place_m), {0.0f, -1.0f, 0.0f});
  if (!isFloor(floor)) return std::nullopt;
  Spot spot;
  spot.floor_m = place_m - glm::dvec3(0.0, floor.distance, 0.0);
  const glm::dvec3 off_floor = spot.floor_m + glm::dvec3(0.0, transport_.nudge(), 0.0);
  const LightHit ceiling = rays_.lightHit(glm::vec3(off_floor), {0.0f, 1.0f, 0.0f});
  spot.headroom_m = ceiling.kind == LightHit::Kind::nothing ? std::numeric_limits<double>::infinity() : double{ceiling.distance};
  spot.has_roof = ceiling.kind == LightHit::Kind::surface;
  if (spot.headroom_m < kLeastHeadroomM) return std::nullopt;
  spot.eye_m = spot.floor_m + glm::dvec3(0.0, std::min(kEyeHeightM, spot.headroom_m - kOverEyesM), 0.0);
  if (!isInExtent(spot.eye_m) || !isInAir(rays_, spot.eye_m)) return std::nullopt;
  for (int turn = 0; turn < kTurns; ++turn) {
    if (isBlocked(spot.eye_m, spot.eye_m + kElbowRoomM * around(turn))) return std::nullopt;
  }
  if (spot.headroom_m < kUprightM && !isLowAround(spot)) return std::nullopt;
  spot.is_upright = spot.headroom_m >= kUprightM && isFreeOfFigure(spot.floor_m);
  spot.is_wide = isWide(spot);
  return spot;
}

bool Spots::isFloor(const LightHit& hit) const {
  if (hit.kind != LightHit::Kind::surface || hit.normal.y < kWalkableSlope) return false;
  const Scene& scene = transport_.scene();
  return hit.is_front || scene.materials[scene.triangle_material[hit.triangle]].double_sided;
}

bool Spots::isFreeOfFigure(const glm::dvec3& floor_m) const {
  constexpr double kTouching = 0.95;  // of a radius: the lowest ball lies on the floor
  for (const FigureBall& ball : kFigure) {
    const glm::dvec3 centre = floor_m + glm::dvec3(0.0, ball.height_m, 0.0), up(0.0, kTouching * ball.radius_m, 0.0);
    if (!isInExtent(centre) || isBlocked(centre - up, centre + up)) return false;
    for (int turn = 0; turn < kTurns; ++turn) {
      if (isBlocked(centre, centre + kTouching * ball.radius_m * around(turn))) return false;
    }
    if (!isInAir(rays_, centre)) return false;
  }
  return true;
}

bool Spots::isLowAround(const Spot& spot) const {
  for (int turn = 0; turn < kTurns; ++turn) {
    const glm::dvec3 beside = spot.eye_m + kStrideM * around(turn);
    if (isBlocked(spot.eye_m, beside)) continue;
    if (!isBlocked(beside, {beside.x, spot.floor_m.y + kUprightM, beside.z})) return false;
  }
  return true;
}

bool Spots::isWide(const Spot& spot) const {
  int free = 0;
  for (int turn = 0; turn < kTurns; ++turn) {
    const glm::dvec3 beside = spot.eye_m + kStrideM * around(turn);
    if (isBlocked(spot.eye_m, beside)) continue;
    ++free;
    const LightHit hit = rays_.lightHit(glm::vec3(beside), {0.0f, -1.0f, 0.0f});
    if (!isFloor(hit) || std::abs(beside.y - hit.distance - spot.floor_m.y) > kStepM) return false;
  }
  return free >= kTurns / 2;
}

}  // namespace nlg
