#include "validate/views/view_surfaces.h"

#include <algorithm>
#include <cmath>

#include "light/directions.h"
#include "light/sunlight.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

constexpr int kTurns = 16;  // of short rays around a normal

bool meetsWithin(const RayScene& rays, const Receiver& receiver, const glm::vec3& direction, double reach_m) {
  return rays.isBlocked(glm::vec3(receiver.position_m), glm::vec3(receiver.position_m + reach_m * glm::dvec3(direction)));
}

// Short rays at an angle to the surface's plane, all around.
bool meetsAround(const RayScene& rays, const Receiver& receiver, double sine, double reach_m) {
  const auto height = static_cast<float>(sine);
  for (int turn = 0; turn < kTurns; ++turn) {
    const glm::vec3 direction = aroundAxis(receiver.normal, height, static_cast<double>(turn) / kTurns);
    if (meetsWithin(rays, receiver, direction, reach_m)) return true;
  }
  return false;
}

uint8_t bitOf(ViewClass of_class) { return static_cast<uint8_t>(1 << static_cast<int>(of_class)); }

uint8_t classesOf(const LightTransport& transport, const Receiver& receiver, bool is_on_figure) {
  uint8_t classes = bitOf(ViewClass::all);
  const RayScene& rays = transport.rays();
  if (is_on_figure) {
    classes |= bitOf(ViewClass::figure);
  } else {
    if (meetsAround(rays, receiver, 0.0, kEdgeM)) classes |= bitOf(ViewClass::edge);
    if (meetsAround(rays, receiver, 0.0, kNearM) || meetsAround(rays, receiver, std::sqrt(0.5), kNearM) ||
        meetsWithin(rays, receiver, receiver.normal, kNearM))
      classes |= bitOf(ViewClass::near);
  }
  const Scene& scene = transport.scene();
  if (scene.light.suns.empty()) return classes;
  const bool is_sunlit = isInSunlight(scene, rays, receiver.position_m, receiver.normal);
  return classes | bitOf(is_sunlit ? ViewClass::sun : ViewClass::shadow);
}

}  // namespace

ViewSurfaces surfacesOf(const LightTransport& transport, const SceneView& view, int width, int height, int thread_count) {
  SightOptions options;
  options.width = width;
  options.height = height;
  options.samples_per_side = 1;
  options.balls = view.figure;
  options.thread_count = thread_count;
  ViewSurfaces surfaces;
  surfaces.sights = sightsOf(transport, view.camera, options);
  surfaces.classes.resize(surfaces.sights.samples.size());
  parallelFor(height, thread_count, [&](uint64_t row, int) {
    for (size_t i = row * width; i < (row + 1) * width; ++i) {
      const Sight& sight = surfaces.sights.samples[i];
      if (sight.kind != Sight::Kind::receiver) continue;
      // no surface's receiver stands exactly at the centre of a ball
      const bool is_on_figure = std::any_of(view.figure.begin(), view.figure.end(),
                                            [&](const Ball& ball) { return ball.centre_m == sight.receiver.position_m; });
      surfaces.classes[i] = classesOf(transport, sight.receiver, is_on_figure);
    }
  });
  return surfaces;
}

}  // namespace nlg
