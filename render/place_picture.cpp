#include "render/place_picture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "render/lit_picture.h"
#include "render/panel.h"
#include "render/tone.h"

namespace nlg {
namespace {

constexpr double kFovY = 1.0;                          // radians
constexpr double kFarthestCameraM = 3.0;               // of the camera
constexpr double kFreeShare = 0.85;                    // of the free way that the camera goes back
constexpr double kSmallBall = 0.07, kLargeBall = 0.1;  // its radius over the camera's distance
constexpr int kLeastRays = 8;                          // of a sample: light/light_transport.h
constexpr double kNeedleRadii = 1.3;                   // the needle's length over the ball's radius
constexpr double kBrightest = 0.6;                     // what the ball is shown as at most
constexpr Colour kNeedle{255, 0, 200};                 // of no material

// Directions from the place: rings around its normal.
std::vector<glm::dvec3> waysBack(const glm::dvec3& normal) {
  constexpr int kTurns = 16;
  const glm::dvec3 aside =
      glm::normalize(glm::cross(normal, std::abs(normal.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0)));
  const glm::dvec3 across = glm::cross(normal, aside);
  std::vector<glm::dvec3> ways;
  for (const double tilt : {25.0, 45.0, 65.0}) {
    const double angle = tilt * std::numbers::pi / 180.0;
    for (int turn = 0; turn < kTurns; ++turn) {
      const double about = 2.0 * std::numbers::pi * turn / kTurns;
      ways.push_back(std::cos(angle) * normal + std::sin(angle) * (std::cos(about) * aside + std::sin(about) * across));
    }
  }
  return ways;
}

// As large as fits between the surfaces around, within bounds that a picture needs.
Ball ballAt(const RayScene& rays, const glm::dvec3& place_m, double distance_m) {
  double free_m = kLargeBall * distance_m;
  for (int i = 0; i < 27; ++i) {
    if (i == 13) continue;  // no direction
    const glm::vec3 way = glm::normalize(glm::vec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
    const LightHit hit = rays.lightHit(glm::vec3(place_m), way);
    if (hit.kind == LightHit::Kind::surface) free_m = std::min<double>(free_m, hit.distance);
  }
  return {place_m, std::max(kSmallBall * distance_m, free_m)};
}

// The share of the ball that a camera sees: of its middle and of 8 points on its rim.
double seenShare(const RayScene& rays, const Camera& camera, const Ball& ball) {
  constexpr int kPoints = 8;
  const glm::dvec3 up(camera.up), right = glm::cross(glm::dvec3(camera.forward), up);
  int seen = 0;
  for (int i = 0; i <= kPoints; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kPoints, radius = i < kPoints ? 0.9 * ball.radius_m : 0.0;
    const glm::dvec3 point = ball.centre_m + radius * (std::cos(angle) * right + std::sin(angle) * up);
    seen += !rays.isBlocked(glm::vec3(camera.eye_m), glm::vec3(point));
  }
  return static_cast<double>(seen) / (kPoints + 1);
}

void drawNeedle(Image& image, const PlaceView& view, const glm::vec3& normal) {
  const double aspect = static_cast<double>(image.width()) / image.height();
  const glm::dvec3 along = view.ball.radius_m * glm::dvec3(normal);
  const auto foot = view.camera.seenAt(view.ball.centre_m + along, aspect);
  const auto tip = view.camera.seenAt(view.ball.centre_m + (1.0 + kNeedleRadii) * along, aspect);
  if (!foot || !tip) return;
  const glm::dvec2 size(image.width(), image.height());
  drawLine(image, *foot * size, *tip * size, 2.0, kNeedle);
  drawLine(image, *foot * size, *foot * size, 5.0, kNeedle);
}

// So that truth's median is middle grey, but the ball's colour at the needle's foot is cut off in neither picture.
double exposureOf(const LitPicture& truth, const MeasuredPlace& place, double least) {
  const glm::vec3 brighter = glm::max(place.truth, place.answer);
  const double radiance = kBallAlbedo * std::max({brighter.r, brighter.g, brighter.b}) / std::numbers::pi;
  const double most = radiance > 0.0 ? kBrightest / radiance : automaticExposure(truth, least);
  return irradianceRms(truth) > 0.0 ? std::min(automaticExposure(truth, least), most) : most;
}

std::string rgbText(const glm::vec3& irradiance) {
  return fmt::format("irradiance {:.3g} {:.3g} {:.3g}", irradiance.r, irradiance.g, irradiance.b);
}

}  // namespace

PlaceView viewOfPlace(const LightTransport& transport, const Receiver& place) {
  constexpr double kLeastM = 1e-3;
  PlaceView best;
  double best_score = -1.0;
  for (const glm::dvec3& way : waysBack(glm::dvec3(place.normal))) {
    const LightHit hit = transport.rays().lightHit(glm::vec3(place.position_m), glm::vec3(way));
    const double free_m = hit.kind == LightHit::Kind::nothing ? INFINITY : double{hit.distance};
    const double distance_m = std::max(kLeastM, std::min(kFarthestCameraM, kFreeShare * free_m));
    PlaceView view{cameraAlong(place.position_m + distance_m * way, -way, kFovY),
                   ballAt(transport.rays(), place.position_m, distance_m)};
    // far rather than near, from a little above rather than along the vertical or from below
    const double height = 1.0 - std::abs(way.y - 0.35);
    const double score = distance_m / kFarthestCameraM + 0.5 * height + 2.0 * seenShare(transport.rays(), view.camera, view.ball);
    if (score > best_score) best_score = score, best = view;
  }
  return best;
}

Image drawPlace(const LightTransport& transport, const MeasuredPlace& place, const LightAt& light_at,
                const PlacePictureOptions& options) {
  // a ball at the sample point, seen from the side that it measures
  const PlaceView view = viewOfPlace(transport, place.at);
  SightOptions sight;
  sight.width = options.width;
  sight.height = options.height;
  // four samples a pixel smooth the ball's rim, if enough rays are left for each
  sight.samples_per_side = options.truth_rays >= 4 * kLeastRays ? 2 : 1;
  sight.balls = {view.ball};
  sight.thread_count = options.thread_count;
  const Sights sights = sightsOf(transport, view.camera, sight);
  // truth and answer on the same samples, with one exposure: what differs is light
  GatherOptions gather;
  gather.rays = options.truth_rays / sights.samples_per_pixel;
  const LitPicture truth = lightPicture(sights, "truth", trueLight(transport, gather, options.seed), options.thread_count);
  const LitPicture answer = lightPicture(sights, place.method, light_at, options.thread_count);
  const double exposure = exposureOf(truth, place, leastAdapted(transport.scene())), range = nextScale(place.error);

  // truth, answer, and their signed difference
  std::vector<PanelColumn> columns = {
      {"truth", {rgbText(place.truth), fmt::format("exposure {:.3g}", exposure)}, toneMapped(truth, exposure), std::nullopt},
      {place.method, {rgbText(place.answer)}, toneMapped(answer, exposure), std::nullopt},
      {"error",
       {"red: too bright", "blue: too dark", fmt::format("full at {:g} of RMS", range)},
       errorMapUpTo(range * place.scale, answer, truth, ErrorKind::with_sign),
       std::nullopt}};
  // the needle shows the normal at which light was measured
  for (PanelColumn& column : columns) drawNeedle(column.picture, view, place.at.normal);
  return drawPanel(columns, {});
}

}  // namespace nlg
