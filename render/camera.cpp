#include "render/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "light/air.h"
#include "render/lit_picture.h"
#include "runtime_eval/numbers/random.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr uint64_t kViewStream = 0x76696577;
constexpr int kEyeDraws = 2000;
constexpr size_t kPlaceCount = 64;
constexpr int kJudgedColumns = 12, kJudgedRows = 7;  // rays of a view that is judged
constexpr double kDownwards = -0.12;                 // of the view's direction: floors are lit, skies are not looked at
constexpr double kWorst = -1e9;

// How much there is to see: the mean and the spread of the logarithm of depth, how many sides and surfaces there are, how much of
// them is lit.
double judge(const LightTransport& transport, const Camera& camera, double aspect, double near_m) {
  std::vector<double> depths;
  std::set<uint32_t> sides;
  int lit = 0;
  for (int i = 0; i < kJudgedColumns * kJudgedRows; ++i) {
    // a coarse grid of rays is enough to judge a view
    const glm::vec3 direction =
        camera.direction((i % kJudgedColumns + 0.5) / kJudgedColumns, (i / kJudgedColumns + 0.5) / kJudgedRows, aspect);
    const glm::vec3 eye(camera.eye_m);
    const LightHit hit = transport.rays().lightHit(eye, direction);
    if (hit.kind != LightHit::Kind::surface) continue;
    const Scene& scene = transport.scene();
    const uint32_t material = scene.triangle_material[hit.triangle];
    // a one-sided face seen from behind: the eye is in solid, or the level is open there
    if (!hit.is_front && !scene.materials[material].double_sided) return kWorst;
    depths.push_back(std::log(std::max<double>(hit.distance, near_m) / near_m));
    sides.insert(surfaceSide(scene, hit));
    // two bounces tell lit from dark
    lit += luminanceOf(transport.radianceAlong(eye, direction, 2, mixSeed(kViewStream, i))) > 0.0;
  }
  // mostly sky or nothing: not a view of the level
  if (depths.size() < kJudgedColumns * kJudgedRows / 2) return kWorst;
  // logarithms of depth: the mean for distance, the spread for variety
  double mean = 0.0, square = 0.0;
  for (const double depth : depths) mean += depth / static_cast<double>(depths.size());
  for (const double depth : depths) square += (depth - mean) * (depth - mean) / static_cast<double>(depths.size());
  const double shown = static_cast<double>(depths.size()) / (kJudgedColumns * kJudgedRows);
  const double lit_share = static_cast<double>(lit) / static_cast<double>(depths.size());
  return mean + std::sqrt(square) + 0.1 * static_cast<double>(sides.size()) + 2.0 * shown + lit_share;
}

}  // namespace

glm::vec3 Camera::direction(double x, double y, double aspect) const {
  const double half_height = std::tan(0.5 * fov_y);
  const glm::dvec3 ahead(forward), upwards(up), right = glm::cross(ahead, upwards);
  return glm::vec3(
      glm::normalize(ahead + right * ((2.0 * x - 1.0) * aspect * half_height) + upwards * ((1.0 - 2.0 * y) * half_height)));
}

std::optional<glm::dvec2> Camera::seenAt(const glm::dvec3& point_m, double aspect) const {
  const glm::dvec3 ahead(forward), upwards(up), right = glm::cross(ahead, upwards), way = point_m - eye_m;
  const double depth = glm::dot(way, ahead), half_height = depth * std::tan(0.5 * fov_y);
  if (!(depth > 0.0)) return std::nullopt;
  return glm::dvec2(0.5 + 0.5 * glm::dot(way, right) / (aspect * half_height), 0.5 - 0.5 * glm::dot(way, upwards) / half_height);
}

Camera cameraAlong(const glm::dvec3& eye_m, const glm::dvec3& direction, double fov_y) {
  constexpr double kVertical = 1.0 - 1e-9;
  const glm::dvec3 ahead = glm::normalize(direction);
  const glm::dvec3 about = std::abs(ahead.y) < kVertical ? glm::dvec3(0.0, 1.0, 0.0) : glm::dvec3(0.0, 0.0, -1.0);
  const glm::dvec3 right = glm::normalize(glm::cross(ahead, about));
  return {eye_m, glm::vec3(ahead), glm::vec3(glm::cross(right, ahead)), fov_y};
}

Camera cameraTurned(const glm::dvec3& eye_m, int turn, double fov_y) {
  const double angle = 2.0 * std::numbers::pi * (turn + 0.5) / kTurnCount;
  return cameraAlong(eye_m, {std::sin(angle), kDownwards, std::cos(angle)}, fov_y);
}

uint32_t surfaceSide(const Scene& scene, const LightHit& hit) {
  const glm::ivec3 way(glm::sign(glm::round(2.0f * hit.normal)));
  return 27 * scene.triangle_material[hit.triangle] + static_cast<uint32_t>(13 + way.x + 3 * way.y + 9 * way.z);
}

Camera bestView(const LightTransport& transport, const std::vector<glm::dvec3>& eyes_m, double fov_y, double aspect) {
  const Bounds bounds = sceneBounds(transport.scene());
  // nearer than this nothing is told apart: a fiftieth of the scene, or what an eye keeps from a wall
  const double near_m = std::min(0.3, 0.02 * glm::length(glm::dvec3(bounds.max - bounds.min)));
  Camera best;
  double best_score = 2.0 * kWorst;
  for (const glm::dvec3& eye_m : eyes_m) {
    for (int turn = 0; turn < kTurnCount; ++turn) {
      const Camera camera = cameraTurned(eye_m, turn, fov_y);
      const double score = judge(transport, camera, aspect, near_m);
      if (score > best_score) best_score = score, best = camera;
    }
  }
  return best;
}

Camera chooseView(const LightTransport& transport, double fov_y, double aspect, uint64_t seed) {
  const Bounds bounds = sceneBounds(transport.scene());
  const glm::dvec3 low(bounds.min), side(bounds.max - bounds.min);
  Random random(mixSeed(seed, kViewStream));
  std::vector<glm::dvec3> places;
  for (int draw = 0; draw < kEyeDraws && places.size() < kPlaceCount; ++draw) {
    const double u = random.uniform(), v = random.uniform(), w = random.uniform();
    const glm::dvec3 place = low + side * glm::dvec3(u, v, w);
    if (isInAir(transport.rays(), place)) places.push_back(place);
  }
  if (places.empty())
    throw InputError(transport.scene().id, "view: no point in air was found to look from; give --eye and --look");
  return bestView(transport, places, fov_y, aspect);
}

}  // namespace nlg
