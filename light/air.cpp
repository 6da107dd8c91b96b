#include "light/air.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "datagen/visibility/cavity.h"
#include "light/directions.h"

namespace nlg {
namespace {

// A level with faces of sky is closed by them: where most rays leave it, they never were inside.
bool isOutside(const RayScene& rays, int nothing) { return rays.hasSkyFaces() && 2 * nothing > kSolidVoteRays; }

constexpr int kPoints = 512, kRays = 16;  // of each point: the share is known to a few hundredths
constexpr int kLampRays = 64;
constexpr int kMostLayers = 32;  // below a place: of more it is not the lowest
constexpr uint64_t kSeed = 0x6f70656e;

// All whose front faces up, by running sum of area in plan.
struct UpwardTriangles {
  std::vector<uint32_t> triangles;
  std::vector<double> area_sums;

  explicit UpwardTriangles(const Scene& scene) {
    double sum = 0.0;
    for (uint32_t t = 0; t < scene.triangles.size(); ++t) {
      const Material& material = scene.materials[scene.triangle_material[t]];
      if (material.transmissive != Transmissive::none) continue;
      const glm::vec3& a = scene.positions[scene.triangles[t].x];
      const glm::vec3 cross = glm::cross(scene.positions[scene.triangles[t].y] - a, scene.positions[scene.triangles[t].z] - a);
      if (!(cross.y > 0.0f)) continue;
      triangles.push_back(t);
      area_sums.push_back(sum += 0.5 * cross.y);
    }
  }
};

// Whether nothing else below a place faces up.
bool isLowest(const RayScene& rays, glm::vec3 place, float lift_m) {
  for (int layer = 0; layer < kMostLayers; ++layer) {
    place.y -= lift_m;
    const LightHit hit = rays.lightHit(place, {0.0f, -1.0f, 0.0f});
    if (hit.kind != LightHit::Kind::surface) return true;
    if (hit.is_front) return false;
    place.y -= hit.distance;
  }
  return false;
}

// Whether a lamp is under the sky, or there is none to ask.
bool lampsAllow(const Scene& scene, const RayScene& rays) {
  const auto seesSky = [&](const Lamp& lamp) {
    const Lattice directions(kSeed);
    for (int ray = 0; ray < kLampRays; ++ray) {
      const auto [u, v] = directions.point(ray, kLampRays);
      if (rays.lightHit(lamp.position, cosineDirection({0.0f, 1.0f, 0.0f}, u, v)).kind == LightHit::Kind::nothing) return true;
    }
    return false;
  };
  const std::vector<Lamp>& lamps = scene.light.lamps;
  return lamps.empty() || std::any_of(lamps.begin(), lamps.end(), seesSky);
}

}  // namespace

Bounds boundsWithSky(const Scene& scene) {
  Bounds bounds = sceneBounds(scene);
  for (const glm::uvec3& triangle : scene.light.sky_faces.triangles) {
    for (int corner = 0; corner < 3; ++corner) {
      bounds.min = glm::min(bounds.min, scene.light.sky_faces.positions[triangle[corner]]);
      bounds.max = glm::max(bounds.max, scene.light.sky_faces.positions[triangle[corner]]);
    }
  }
  return bounds;
}

ExtentBox lightExtent(const Scene& scene, const std::vector<std::string>& extent_m) {
  if (const auto extent = extentFromNumbers(extent_m)) return {extent->low_m - scene.origin_m, extent->high_m - scene.origin_m};
  if (scene.extent) return {scene.extent->low_m - scene.origin_m, scene.extent->high_m - scene.origin_m};
  const Bounds bounds = boundsWithSky(scene);
  return {glm::dvec3(bounds.min), glm::dvec3(bounds.max)};
}

bool isInAir(const RayScene& rays, const glm::dvec3& position_m) {
  return AirVoter(rays).isAir(position_m) && !isInCavity(rays, position_m);
}

AirVoter::AirVoter(const RayScene& rays) : rays_(rays) { std::iota(order_.begin(), order_.end(), uint8_t{0}); }

bool AirVoter::isAir(const glm::dvec3& position_m) {
  SolidVote vote;
  for (int i = 0; i < kSolidVoteRays; ++i) {
    const Facing facing = rays_.firstBackWithSky(glm::vec3(position_m), voteDirections()[order_[i]]);
    vote.nothing += facing == Facing::nothing;
    if (isOutside(rays_, vote.nothing)) return false;
    if (facing != Facing::back) continue;
    ++vote.back;
    // a ray that found a back goes first at the next point, which is likely in the same solid
    std::rotate(order_.begin(), order_.begin() + i, order_.begin() + i + 1);
    // were all others fronts, it would be disputed
    if (10 * vote.back > kSolidVoteRays) return false;
  }
  if (vote.back == 0) return true;
  const SolidVote whole = solidVoteWithSky(rays_, position_m);
  return !whole.solid() && !whole.disputed();
}

bool AirVoter::meetsNoFront(const glm::dvec3& position_m) {
  SolidVote vote;
  for (int i = kSolidVoteRays - 1, others = 0; i >= 0; --i) {
    const Facing facing = rays_.firstFacingWithSky(glm::vec3(position_m), voteDirections()[order_[i]]);
    vote.back += facing == Facing::back;
    vote.nothing += facing == Facing::nothing;
    if (facing == Facing::back) continue;
    std::rotate(order_.begin() + i, order_.begin() + i + 1, order_.end());
    // fewer faces than are asked for
    if (facing == Facing::front || (2 * ++others > kSolidVoteRays && !rays_.hasSkyFaces())) return false;
  }
  return vote.unanimous() || isOutside(rays_, vote.nothing);
}

double openShare(const Scene& scene) {
  const UpwardTriangles upward(scene);
  if (upward.triangles.empty()) return 0.0;
  const RayScene rays(scene);
  if (!lampsAllow(scene, rays)) return 0.0;
  float furthest = 0.0f;
  // a lift larger than the rounding of positions at the scene's furthest vertex
  for (const glm::vec3& p : scene.positions) furthest = std::max({furthest, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
  const float lift_m = std::max(1e-4f, furthest * 0x1p-18f);
  const Lattice on_surface(kSeed);
  // ground by its area in plan, spread over all of it
  int open = 0, asked = 0;
  for (int i = 0; i < kPoints; ++i) {
    const auto [place, within] = on_surface.point(i, kPoints);
    const auto chosen = std::upper_bound(upward.area_sums.begin(), upward.area_sums.end(), place * upward.area_sums.back());
    const size_t at = std::min<size_t>(chosen - upward.area_sums.begin(), upward.triangles.size() - 1);
    const glm::uvec3& corners = scene.triangles[upward.triangles[at]];
    Random random(mixSeed(kSeed, i));
    const auto root = static_cast<float>(std::sqrt(within)), share = static_cast<float>(random.uniform());
    const glm::vec3 point = scene.positions[corners.x] * (1.0f - root) + scene.positions[corners.y] * (root * (1.0f - share)) +
                            scene.positions[corners.z] * (root * share);
    // only the lowest ground: a roof in the open says nothing of the rooms below
    if (!isLowest(rays, point, lift_m)) continue;
    ++asked;
    // cosine-weighted: the share of open rays is that of a uniform sky's light
    const Lattice directions(mixSeed(kSeed, i, 1));
    for (int ray = 0; ray < kRays; ++ray) {
      const auto [u, v] = directions.point(ray, kRays);
      const glm::vec3 up(0.0f, 1.0f, 0.0f);
      open += rays.lightHit(point + up * lift_m, cosineDirection(up, u, v)).kind == LightHit::Kind::nothing;
    }
  }
  return asked == 0 ? 0.0 : static_cast<double>(open) / (asked * kRays);
}

}  // namespace nlg
