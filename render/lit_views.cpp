#include "render/lit_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "light/air.h"
#include "light/standing.h"
#include "render/lit_picture.h"
#include "runtime_eval/numbers/random.h"
#include "tool/error.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

constexpr uint64_t kEyeStream = 0x6c697465796573;
constexpr int kPlaceDraws = 4000;
constexpr size_t kMostEyes = 96;
constexpr int kColumns = 16, kRows = 9;  // rays of a view that is judged
constexpr double kOffsetM = 0.02;        // light is asked for so far before a surface, as pictures do
constexpr double kSeenWorth = 0.2;       // of what an earlier view shows
constexpr double kSideWorth = 0.05;      // of each side that is seen, over the worth of a view

// The best kind of eye that there is.
std::vector<glm::dvec3> eyesIn(const LightTransport& transport, const ExtentBox& extent, uint64_t seed) {
  Random random(mixSeed(seed, kEyeStream));
  const Spots spots(transport, extent);
  std::array<std::vector<glm::dvec3>, 4> eyes;
  for (int draw = 0; draw < kPlaceDraws && eyes[0].size() < kMostEyes; ++draw) {
    const double u = random.uniform(), v = random.uniform(), w = random.uniform();
    const glm::dvec3 place = extent.low_m + (extent.high_m - extent.low_m) * glm::dvec3(u, v, w);
    if (!isInAir(transport.rays(), place)) continue;
    if (eyes[3].size() < kMostEyes) eyes[3].push_back(place);
    const std::optional<Spot> spot = spots.below(place);
    if (spot) eyes[spot->is_upright ? (spot->is_wide ? 0 : 1) : 2].push_back(spot->eye_m);
  }
  const auto found = std::find_if(eyes.begin(), eyes.end(), [](const auto& kind) { return !kind.empty(); });
  if (found == eyes.end()) return {};
  if (found->size() > kMostEyes) found->resize(kMostEyes);
  return *found;
}

}  // namespace

LitViews::LitViews(const LightTransport& transport, const LightAt& light_at, const ExtentBox& extent,
                   const LitViewOptions& options)
    : transport_(transport), light_at_(light_at), options_(options) {
  const double side_m = glm::length(extent.high_m - extent.low_m);
  near_m_ = std::min(near_m_, 0.05 * side_m);
  cell_m_ = std::max(0.5 * near_m_, side_m / 64.0);
  const std::vector<glm::dvec3> eyes = eyesIn(transport, extent, options.seed);
  candidates_.resize(eyes.size() * kTurnCount);
  parallelFor(candidates_.size(), options.thread_count, [&](uint64_t c, int) {
    candidates_[c].camera = cameraTurned(eyes[c / kTurnCount], static_cast<int>(c % kTurnCount), options.fov_y);
    candidates_[c].points = pointsOf(candidates_[c].camera);
  });
  // between the mean, which a patch of sun decides, and the median, which may be that of dark rooms
  double roots = 0.0, count = 0.0;
  for (const Candidate& candidate : candidates_) {
    for (const Point& point : candidate.points) roots += std::sqrt(std::max(0.0f, point.light)), ++count;
  }
  usual_light_ = count > 0.0 ? roots * roots / (count * count) : 0.0;
}

std::vector<LitViews::Point> LitViews::pointsOf(const Camera& camera) const {
  std::vector<Point> points;
  std::vector<Receiver> receivers;
  const glm::vec3 eye(camera.eye_m);
  for (int i = 0; i < kColumns * kRows; ++i) {
    const glm::vec3 direction = camera.direction((i % kColumns + 0.5) / kColumns, (i / kColumns + 0.5) / kRows, options_.aspect);
    const LightHit hit = transport_.rays().lightHit(eye, direction);
    if (hit.kind != LightHit::Kind::surface) continue;
    const Scene& scene = transport_.scene();
    const bool is_back = !hit.is_front && !scene.materials[scene.triangle_material[hit.triangle]].double_sided;
    const glm::vec3 at = eye + direction * hit.distance;
    points.push_back({at, is_back ? -1.0f : 0.0f, static_cast<float>(std::log(hit.distance / near_m_)), surfaceSide(scene, hit)});
    receivers.push_back({glm::dvec3(at) + kOffsetM * glm::dvec3(hit.normal), hit.normal});
  }
  const std::vector<LightAnswer> received = answersAt(light_at_, receivers, 1);
  for (size_t i = 0; i < points.size(); ++i) {
    if (points[i].light == 0.0f) points[i].light = static_cast<float>(luminanceOf(received[i].irradiance));
  }
  return points;
}

double LitViews::worthOf(const Camera& camera) const { return worthOf(pointsOf(camera)); }

double LitViews::worthOf(const std::vector<Point>& points) const {
  double worth = 0.0;
  std::set<uint32_t> sides;
  for (const Point& point : points) {
    const double lit = usual_light_ > 0.0 ? std::min(1.0, point.light / usual_light_) : 1.0;
    if (point.light < 0.0f || point.weight < 0.0f) {
      worth -= 1.0;
      continue;
    }
    worth += lit * point.weight * (seen_.contains(cellOf(point)) ? kSeenWorth : 1.0);
    sides.insert(point.side);
  }
  return (1.0 + kSideWorth * static_cast<double>(sides.size())) * worth / (kColumns * kRows);
}

uint64_t LitViews::cellOf(const Point& point) const {
  const glm::i64vec3 cell(glm::floor(glm::dvec3(point.at) / cell_m_));
  return mixSeed(static_cast<uint64_t>(cell.x), static_cast<uint64_t>(cell.y), static_cast<uint64_t>(cell.z));
}

void LitViews::markSeen(const std::vector<Point>& points) {
  for (const Point& point : points) seen_.insert(cellOf(point));
}

const LitViews::Candidate* LitViews::best() const {
  const Candidate* best = nullptr;
  double most = 0.0;
  for (const Candidate& candidate : candidates_) {
    const double worth = worthOf(candidate.points);
    if (best == nullptr || worth > most) most = worth, best = &candidate;
  }
  return best;
}

double LitViews::bestWorth() const { return best() == nullptr ? 0.0 : worthOf(best()->points); }

Camera LitViews::takeBest() {
  const Candidate* const chosen = best();
  if (chosen == nullptr) throw InputError(transport_.scene().id, "view: no point in air was found to look from");
  markSeen(chosen->points);
  return chosen->camera;
}

}  // namespace nlg
