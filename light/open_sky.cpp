#include "light/open_sky.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "datagen/visibility/ray_scene.h"
#include "light/directions.h"

namespace nlg {
namespace {

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
      if (material.veil != Veil::none) continue;
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

double openShare(const Scene& scene) {
  const UpwardTriangles upward(scene);
  if (upward.triangles.empty()) return 0.0;
  const RayScene rays(scene);
  if (!lampsAllow(scene, rays)) return 0.0;
  float furthest = 0.0f;
  for (const glm::vec3& p : scene.positions) furthest = std::max({furthest, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
  const float lift_m = std::max(1e-4f, furthest * 0x1p-18f);
  const Lattice on_surface(kSeed);
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
    if (!isLowest(rays, point, lift_m)) continue;
    ++asked;
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
