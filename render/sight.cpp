#include "render/sight.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "light/air.h"
#include "scene/model/surface_look.h"
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

// What is seen along a ray, through the transmissive surfaces before it.
struct Seen {
  LightHit hit;
  float stopped = 1.0f;     // of light, by what is seen: a transmissive surface stops a part
  glm::vec3 through{1.0f};  // colour of the transmissive surfaces before it
};

// A sample sees a transmissive surface or what is behind it, never both: its chance, evenly spread over the samples of a pixel,
// says which.
// far   in lengths of the direction: as far as the surface that ends it all
Seen seenAlong(const LightTransport& transport, const glm::vec3& eye, const glm::vec3& direction, float chance, float far) {
  Seen seen;
  LightHit pane = transport.rays().transmissiveHit(eye, direction, 0.0f, far);
  for (; pane.kind == LightHit::Kind::surface;
       pane = transport.rays().transmissiveHit(eye, direction, RayScene::justBehind(pane), far)) {
    const glm::vec3 passes = transmissiveAt(transport.scene(), pane.triangle, pane.u, pane.v).passes;
    const float passing = std::max({passes.r, passes.g, passes.b}), stopped = 1.0f - passing;
    if (chance < stopped) {
      seen.hit = pane;
      seen.stopped = stopped;
      return seen;
    }
    chance = (chance - stopped) / passing;
    seen.through *= passes / passing;
  }
  seen.hit = transport.rays().lightHit(eye, direction);
  return seen;
}

Sight surfaceSight(const LightTransport& transport, const Seen& seen, const glm::vec3& point, double offset_m) {
  const LightHit& hit = seen.hit;
  Sight sight;
  sight.kind = Sight::Kind::receiver;
  // never behind what stands before the surface
  const glm::vec3 off_surface = point + hit.normal * transport.nudge();
  const LightHit before = transport.rays().lightHit(off_surface, hit.normal);
  const double free_m = before.kind == LightHit::Kind::surface ? 0.5 * before.distance : offset_m;
  sight.receiver = {glm::dvec3(off_surface) + std::min(offset_m, free_m) * glm::dvec3(hit.normal), hit.normal};
  sight.albedo = transport.albedo(hit) * seen.through / seen.stopped;
  sight.shine = transport.emission(hit) * seen.through / seen.stopped;
  return sight;
}

// chance   in [0, 1), of this sample: whether it sees a transmissive surface or what is behind it
Sight sightAlong(const LightTransport& transport, const Camera& camera, const glm::vec3& direction, const SightOptions& options,
                 float chance) {
  // the nearest of scene and balls ends the ray
  const glm::vec3 eye(camera.eye_m);
  const LightHit hit = transport.rays().lightHit(eye, direction);
  double nearest = hit.kind == LightHit::Kind::nothing ? INFINITY : hit.distance;
  const Ball* met = nullptr;
  for (const Ball& ball : options.balls) {
    const std::optional<double> entry = entryOf(ball, camera.eye_m, glm::dvec3(direction));
    if (entry && *entry < nearest) nearest = *entry, met = &ball;
  }
  // transmissive surfaces before this end come first: by chance one of them is what is seen
  const Seen seen = seenAlong(transport, eye, direction, chance, static_cast<float>(nearest));
  const bool is_transmissive = seen.hit.kind == LightHit::Kind::surface && seen.hit.distance < nearest;
  if (is_transmissive || (met == nullptr && seen.hit.kind == LightHit::Kind::surface))
    return surfaceSight(transport, seen, eye + direction * seen.hit.distance, options.offset_m);
  // a ball is lit by the light at its centre, as a moving object would be
  Sight sight;
  if (met != nullptr) {
    sight.kind = Sight::Kind::receiver;
    const glm::dvec3 point = camera.eye_m + nearest * glm::dvec3(direction);
    sight.receiver = {met->centre_m, glm::vec3(glm::normalize(point - met->centre_m))};
    sight.albedo = glm::vec3(kBallAlbedo) * seen.through;
    return sight;
  }
  // a sky face of a level may have a colour of its own
  const SceneLight& light = transport.scene().light;
  const glm::vec3 sky = hit.kind == LightHit::Kind::sky ? light.sky_faces.radiance(hit.triangle, direction, light.sky)
                                                        : light.sky.radiance(direction);
  sight.shine = sky * seen.through;
  return sight;
}

// Of the samples of a pixel each has another share of [0, 1), and neighbours have them in another order.
float chanceOf(int x, uint64_t row, int sample, int sample_count) {
  const int shift = static_cast<int>((static_cast<uint64_t>(x) + 2 * row) % static_cast<uint64_t>(sample_count));
  return (static_cast<float>((sample + shift) % sample_count) + 0.5f) / static_cast<float>(sample_count);
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
        *sample++ = sightAlong(transport, camera, camera.direction(px / options.width, py / options.height, aspect), options,
                               chanceOf(x, row, i, n * n));
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
