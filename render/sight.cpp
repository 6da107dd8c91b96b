#include "render/sight.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "light/air.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

// Where a ray of unit direction enters a ball, metres; nothing when it passes by or begins inside.
std::optional<double> entryOf(const Ball& ball, const glm::dvec3& origin, const glm::dvec3& direction) {
  const glm::dvec3 to_centre = ball.centre_m - origin;
  const double along = glm::dot(to_centre, direction);
  const glm::dvec3 aside = to_centre - along * direction;
  const double inside = ball.radius_m * ball.radius_m - glm::dot(aside, aside);
  if (inside < 0.0 || along <= std::sqrt(inside)) return std::nullopt;
  return along - std::sqrt(inside);
}

Sight surfaceSight(const LightTransport& transport, const LightHit& hit, const glm::vec3& point, double offset_m) {
  Sight sight;
  sight.kind = Sight::Kind::receiver;
  // never behind what stands before the surface
  const glm::vec3 off_surface = point + hit.normal * transport.nudge();
  const LightHit before = transport.rays().lightHit(off_surface, hit.normal);
  const double free_m = before.kind == LightHit::Kind::surface ? 0.5 * before.distance : offset_m;
  sight.receiver = {glm::dvec3(off_surface) + std::min(offset_m, free_m) * glm::dvec3(hit.normal), hit.normal};
  sight.albedo = transport.albedo(hit.triangle);
  const Scene& scene = transport.scene();
  const Material& material = scene.materials[scene.triangle_material[hit.triangle]];
  if (hit.is_front || material.double_sided) sight.shine = material.emissive;
  return sight;
}

Sight sightAlong(const LightTransport& transport, const Camera& camera, const glm::vec3& direction, const SightOptions& options) {
  const glm::vec3 eye(camera.eye_m);
  const LightHit hit = transport.rays().lightHit(eye, direction);
  double nearest = hit.kind == LightHit::Kind::surface ? hit.distance : INFINITY;
  const Ball* met = nullptr;
  for (const Ball& ball : options.balls) {
    const std::optional<double> entry = entryOf(ball, camera.eye_m, glm::dvec3(direction));
    if (entry && *entry < nearest) nearest = *entry, met = &ball;
  }
  Sight sight;
  if (met != nullptr) {
    sight.kind = Sight::Kind::receiver;
    const glm::dvec3 point = camera.eye_m + nearest * glm::dvec3(direction);
    sight.receiver = {met->centre_m, glm::vec3(glm::normalize(point - met->centre_m))};
    sight.albedo = glm::vec3(kBallAlbedo);
    return sight;
  }
  if (hit.kind == LightHit::Kind::surface) return surfaceSight(transport, hit, eye + direction * hit.distance, options.offset_m);
  // no surface stands there: the sky's radiance is all that comes, whatever the seed
  sight.shine = transport.radianceAlong(eye, direction, 0, 0);
  return sight;
}

}  // namespace

Sights sightsOf(const LightTransport& transport, const Camera& camera, const SightOptions& options) {
  const int n = options.samples_per_side;
  Sights sights{options.width, options.height, n * n, {}};
  sights.samples.resize(static_cast<size_t>(options.width) * options.height * n * n);
  const double aspect = static_cast<double>(options.width) / options.height;
  parallelFor(options.height, options.thread_count, [&](uint64_t row, int) {
    Sight* sample = &sights.samples[row * options.width * n * n];
    for (int x = 0; x < options.width; ++x) {
      for (int i = 0; i < n * n; ++i) {
        const double px = x + (i % n + 0.5) / n, py = static_cast<double>(row) + (i / n + 0.5) / n;
        *sample++ = sightAlong(transport, camera, camera.direction(px / options.width, py / options.height, aspect), options);
      }
    }
  });
  return sights;
}

Sights sightsOfCut(const LightTransport& transport, const Cut& cut, int width, int thread_count) {
  const glm::dvec3 side = cut.high_m - cut.low_m;
  const int height = std::max(1, static_cast<int>(std::lround(width * side.z / side.x)));
  Sights sights{width, height, 1, {}};
  sights.samples.resize(static_cast<size_t>(width) * height);
  parallelFor(height, thread_count, [&](uint64_t row, int) {
    for (int x = 0; x < width; ++x) {
      Sight& sight = sights.samples[row * width + x];
      const glm::dvec3 place = cut.low_m + side * glm::dvec3((x + 0.5) / width, 0.0, (static_cast<double>(row) + 0.5) / height);
      const bool in_air = isInAir(transport.rays(), place);
      sight.kind = in_air ? Sight::Kind::receiver : Sight::Kind::solid;
      sight.receiver = {place, {0.0f, 1.0f, 0.0f}};
      sight.albedo = glm::vec3(1.0f);
    }
  });
  return sights;
}

}  // namespace nlg
