#include "bake/blend_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "nlg/look_up.h"
#include "runtime_eval/numbers/random.h"
#include "tool/parallel_for.h"
#include "tool/printable.h"

namespace nlg {
namespace {

constexpr uint64_t kStream = 0x626c656e64;
constexpr int kDraws = 24;        // of a point, at most: half of all surface has solid behind it
constexpr double kClearM = 1e-3;  // from the surface itself, on which a ray would end
constexpr size_t kNearest = 4;    // samples

bool sees(const RayScene& rays, const glm::dvec3& from, const glm::dvec3& to) {
  return !rays.isBlocked(glm::vec3(from), glm::vec3(to));
}

glm::dvec3 inSupport(const ProbeTree& tree, uint64_t probe, const LocalPoint& local) {
  const auto [x, y, z] = tree.probePosition(probe);
  return glm::dvec3(x, y, z) + double{tree.probeSpacing(probe)} * glm::dvec3(local[0], local[1], local[2]);
}

// The first whose running sum is above a random share of all; nothing where all are 0.
std::optional<size_t> drawBy(const std::vector<double>& running, Random& random) {
  const double drawn = running.empty() ? 0.0 : random.uniform() * running.back();
  const auto found = std::upper_bound(running.begin(), running.end(), drawn);
  return found == running.end() ? std::nullopt : std::optional(static_cast<size_t>(found - running.begin()));
}

class PointDraws {
 public:
  explicit PointDraws(const PreparedScene& scene) : scene_(scene) {
    double volume = 0.0, area = 0.0;
    for (const AirPlaces::Cell& cell : scene.air.cells) {
      if (cell.count == 0) continue;
      cells_.push_back(&cell);
      volume_.push_back(volume += std::pow(cell.cell.side, 3) * cell.air_share);
      cell_at_.emplace(cell.cell.low, &cell);
    }
    for (const glm::uvec3& triangle : scene.rays.triangles()) area_.push_back(area += glm::length(areaNormal(triangle)));
  }

  std::optional<BlendPoint> draw(size_t blend_class, Random random) const {
    BlendPoint point;
    point.blend_class = blend_class;
    for (int n = 0; n < kDraws; ++n) {
      const std::optional<glm::dvec3> at = blend_class == 0 ? inAir(random) : beforeSurface(random, blend_class);
      if (!at || !scene_.tree.lookUp({at->x, at->y, at->z}, &point.around) || !isSeenByAir(*at, point.around.cell)) continue;
      point.position_m = scene_.source.scene.origin_m + *at;
      return point;
    }
    return std::nullopt;
  }

 private:
  // Twice the area long.
  glm::dvec3 areaNormal(const glm::uvec3& triangle) const {
    const std::vector<glm::vec3>& corners = scene_.rays.positions();
    const glm::dvec3 first(corners[triangle.x]);
    return glm::cross(glm::dvec3(corners[triangle.y]) - first, glm::dvec3(corners[triangle.z]) - first);
  }

  std::optional<glm::dvec3> inAir(Random& random) const {
    const std::optional<size_t> drawn = drawBy(volume_, random);
    if (!drawn) return std::nullopt;
    const ProbeCell& cell = cells_[*drawn]->cell;
    const ProbeTreeFrame& frame = scene_.tree.frame();
    glm::dvec3 at;
    for (int axis = 0; axis < 3; ++axis)
      at[axis] = frame.first_m[axis] + frame.spacing_m * (cell.low[axis] + cell.side * random.uniform());
    return at;
  }

  std::optional<glm::dvec3> beforeSurface(Random& random, size_t blend_class) const {
    const std::optional<size_t> drawn = drawBy(area_, random);
    if (!drawn) return std::nullopt;
    const glm::uvec3& triangle = scene_.rays.triangles()[*drawn];
    const std::vector<glm::vec3>& corners = scene_.rays.positions();
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
    const glm::dvec3 a(corners[triangle.x]), b(corners[triangle.y]), c(corners[triangle.z]), on = a + u * (b - a) + v * (c - a);
    const glm::dvec3 normal = glm::normalize(areaNormal(triangle)) * (random.chance(0.5) ? 1.0 : -1.0);
    const double near = std::max(2.0 * kClearM, kBlendBordersM[blend_class - 1]), far = kBlendBordersM[blend_class];
    const glm::dvec3 at = on + random.uniform(near, far) * normal;
    return sees(scene_.rays, on + kClearM * normal, at) ? std::optional(at) : std::nullopt;
  }

  bool isSeenByAir(const glm::dvec3& at, const ProbeCell& cell) const {
    const auto found = cell_at_.find(cell.low);
    if (found == cell_at_.end()) return false;
    const auto first = scene_.air.places.begin() + found->second->first;
    return std::any_of(first, first + found->second->count,
                       [&](const glm::dvec3& place) { return sees(scene_.rays, place, at); });
  }

  const PreparedScene& scene_;
  std::vector<const AirPlaces::Cell*> cells_;  // that hold air
  std::map<LatticePoint, const AirPlaces::Cell*> cell_at_;
  std::vector<double> volume_, area_;  // running sums: of air in cells_, units³; of triangles, twice m²
};

constexpr float kNoTarget = 0.005f;  // sum of target weights: at the rim of what anybody sees shares are noise
constexpr float kHoleTarget = 0.05f, kHoleWeight = 0.02f;  // sums of target weights, and of the look-up's
constexpr float kLeakTarget = 0.001f, kLeakShare = 0.2f;   // of single probes; of all such together

void addPoint(const BlendPoint& point, const LightGrid& grid, BlendFigures* figures) {
  const float targets = std::accumulate(point.target.begin(), point.target.end(), 0.0f);
  ProbeWeights weights;
  if (targets <= kNoTarget || !lookUpWeights(grid, {point.position_m.x, point.position_m.y, point.position_m.z}, &weights))
    return;
  const float sum = std::accumulate(weights.weight, weights.weight + weights.count, 0.0f);
  const double certainty = weights.count > 0 ? double{weights.certainty} : 0.0;
  // what the certainty leaves out is light of no target
  double astray = 0.0, difference = 1.0 - certainty;
  for (int c = 0; c < 8; ++c) {
    double share = 0.0;
    for (int i = 0; i < weights.count; ++i) {
      if (weights.probe[i] == point.around.corners[c].probe) share = certainty * double{weights.weight[i]} / double{sum};
    }
    if (point.target[c] < kLeakTarget) astray += share;
    difference += std::abs(share - double{point.target[c]} / double{targets});
  }
  ++figures->points;
  figures->holes += targets > kHoleTarget && sum < kHoleWeight;
  figures->leaks += astray > kLeakShare;
  figures->total_variation += 0.5 * difference;
}

nlohmann::ordered_json figuresJson(const BlendFigures& figures) {
  return {{"points", figures.points},
          {"holes", figures.holes},
          {"leaks", figures.leaks},
          {"total_variation", figures.total_variation}};
}

}  // namespace

BlendTargets::BlendTargets(const PreparedScene& scene, uint64_t seed, int thread_count)
    : scene_(scene), first_corner_(scene.tree.probeCount() + 1) {
  constexpr uint64_t kBlock = 64;
  const PointDraws draws(scene);
  std::vector<std::optional<BlendPoint>> drawn(kBlendAirPoints + kBlendSurfacePoints);
  parallelForBlocks(drawn.size(), kBlock, thread_count, [&](uint64_t first, uint64_t end, int) {
    // a random stream for each point, so that points do not depend on threads
    for (uint64_t n = first; n < end; ++n)
      drawn[n] = draws.draw(n < kBlendAirPoints ? 0 : 1 + n % (kBlendClassCount - 1), Random(mixSeed(seed, kStream, n)));
  });
  for (const std::optional<BlendPoint>& point : drawn) {
    if (point) points_.push_back(*point);
  }
  // sorted by probe, by counting
  for (const BlendPoint& point : points_) {
    for (const ProbeAround& at : point.around.corners) ++first_corner_[at.probe + 1];
  }
  for (size_t p = 1; p < first_corner_.size(); ++p) first_corner_[p] += first_corner_[p - 1];
  corners_.resize(8 * points_.size());
  std::vector<uint64_t> next = first_corner_;
  for (uint32_t p = 0; p < points_.size(); ++p) {
    for (uint8_t c = 0; c < 8; ++c) corners_[next[points_[p].around.corners[c].probe]++] = {p, c};
  }
}

void BlendTargets::setTargets(uint64_t probe, const LocalPoint& eye, const std::function<StoredFunction()>& samples) {
  const glm::dvec3 from = inSupport(scene_.tree, probe, eye);
  std::optional<StoredFunction> function;
  for (uint64_t n = first_corner_[probe]; n < first_corner_[probe + 1]; ++n) {
    BlendPoint& point = points_[corners_[n].point];
    const ProbeAround& at = point.around.corners[corners_[n].corner];
    const glm::dvec3 position = point.position_m - scene_.source.scene.origin_m;
    float share = 1.0f;
    if (samples && !sees(scene_.rays, from, position)) {
      if (!function) function = samples();
      share = diffusedShare(*function, at, position);
    }
    point.target[corners_[n].corner] = share * tent(at.local) * at.tent_ratio;
  }
}

float BlendTargets::diffusedShare(const StoredFunction& function, const ProbeAround& at, const glm::dvec3& position) const {
  const std::vector<LocalPoint>& points = supportPattern().points;
  static const PointSet octant = makePointSet({points.begin(), points.begin() + kOctantPointCount});
  // mirrored into the positive octant: 1024 distances instead of 8192
  const float x = std::abs(at.local[0]), y = std::abs(at.local[1]), z = std::abs(at.local[2]);
  const int mirror = (at.local[0] < 0.0f) | (at.local[1] < 0.0f) << 1 | (at.local[2] < 0.0f) << 2;
  // a loop by itself, which compilers turn into vectors
  std::array<float, kOctantPointCount> square;
  for (int i = 0; i < kOctantPointCount; ++i) {
    const float dx = octant.x[i] - x, dy = octant.y[i] - y, dz = octant.z[i] - z;
    square[i] = dx * dx + dy * dy + dz * dz;
  }
  std::array<std::pair<float, int>, kNearest> nearest;  // rising
  nearest.fill({std::numeric_limits<float>::max(), 0});
  for (int i = 0; i < kOctantPointCount; ++i) {
    if (square[i] >= nearest.back().first) continue;
    nearest.back() = {square[i], mirror * kOctantPointCount + i};
    for (size_t k = kNearest - 1; k > 0 && nearest[k] < nearest[k - 1]; --k) std::swap(nearest[k], nearest[k - 1]);
  }
  // rays for nothing otherwise
  if (std::all_of(nearest.begin(), nearest.end(), [&](const auto& near) { return function.phi[near.second] == 0; })) return 0.0f;
  // v of docs/theory/errors.md: the mean of min(1, phi / tent) over nearest samples that are valid and see the point
  float sum = 0.0f, count = 0.0f;
  for (const auto& [of_distance, sample] : nearest) {
    if (!function.isValid(sample) || !sees(scene_.rays, inSupport(scene_.tree, at.probe, points[sample]), position)) continue;
    sum += std::min(1.0f, static_cast<float>(function.phi[sample]) / (255.0f * tent(points[sample])));
    ++count;
  }
  return count > 0.0f ? sum / count : 0.0f;
}

BlendErrors blendErrors(const BlendTargets& targets, const LightGrid& grid) {
  BlendErrors errors;
  for (const BlendPoint& point : targets.points()) addPoint(point, grid, &errors[point.blend_class]);
  for (BlendFigures& figures : errors) {
    for (double* mean : {&figures.holes, &figures.leaks, &figures.total_variation})
      *mean /= std::max(1.0, static_cast<double>(figures.points));
  }
  return errors;
}

nlohmann::ordered_json toJson(const BlendErrors& errors) {
  nlohmann::ordered_json json = {{"air", figuresJson(errors[0])}, {"surface", nlohmann::ordered_json::array()}};
  for (size_t c = 1; c < errors.size(); ++c) {
    json["surface"].push_back({{"from_m", kBlendBordersM[c - 1]}, {"to_m", kBlendBordersM[c]}});
    json["surface"].back().update(figuresJson(errors[c]));
  }
  return json;
}

}  // namespace nlg
