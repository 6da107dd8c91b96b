#include "validate/solved/comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

namespace nlg {
namespace {

constexpr float kOccludedTent = 0.02f;
constexpr float kWayLimit_m = 2.0f;   // two spacings
constexpr float kFirstStep_m = 0.5f;  // the way from a probe begins at points that it sees within this

// For each probe and corner of every point: does the probe see it?
std::vector<std::array<uint8_t, kCornerCount>> seenCorners(const SolvedScene& scene) {
  std::vector<std::array<uint8_t, kCornerCount>> seen(scene.points.count());
  for (size_t i = 0; i < seen.size(); ++i) {
    for (int c = 0; c < kCornerCount; ++c) {
      const int probe = scene.points.probe[i][c];
      if (probe < 0) continue;
      const ProbeView& view = scene.views[probe];
      seen[i][c] = view.free_space || view.seen[kSupportPointCount + scene.points.cell_point[i] * kCornerCount + c];
    }
  }
  return seen;
}

// Metres from a probe to every point (Dijkstra over the links).
std::vector<float> waysFrom(const SolvedScene& scene, const glm::vec3& probe_m) {
  const float infinity = std::numeric_limits<float>::infinity();
  std::vector<float> way(scene.points.count(), infinity);
  std::vector<uint32_t> near;
  std::vector<glm::vec3> a, b;
  for (uint32_t i = 0; i < way.size(); ++i) {
    if (glm::distance(probe_m, scene.points.position_m[i]) > kFirstStep_m) continue;
    near.push_back(i);
    a.push_back(probe_m);
    b.push_back(scene.points.position_m[i]);
  }
  const std::vector<uint8_t> open = seeEachOther(scene.rays, a, b);
  using Entry = std::pair<float, uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (size_t k = 0; k < near.size(); ++k) {
    if (open[k]) queue.emplace(way[near[k]] = glm::distance(a[k], b[k]), near[k]);
  }
  while (!queue.empty()) {
    const auto [length, point] = queue.top();
    queue.pop();
    if (length > way[point] || length > 2.0f * kWayLimit_m) continue;
    for (uint32_t e = scene.links.first[point]; e < scene.links.first[point + 1]; ++e) {
      const uint32_t link = scene.links.of[e], other = scene.links.other(link, point);
      const float longer = length + scene.links.links[link].distance_m;
      if (longer < way[other]) queue.emplace(way[other] = longer, other);
    }
  }
  return way;
}

// Points that a probe sees have their straight distance.
BlendWeights findPaths(const SolvedScene& scene, const std::vector<std::array<uint8_t, kCornerCount>>& seen) {
  std::vector<std::vector<float>> ways;
  for (const glm::vec3& probe : scene.points.probe_position_m) ways.push_back(waysFrom(scene, probe));
  BlendWeights path(scene.points.count());
  for (size_t i = 0; i < path.size(); ++i) {
    for (int c = 0; c < kCornerCount; ++c) {
      const int probe = scene.points.probe[i][c];
      if (probe < 0) continue;
      path[i][c] = seen[i][c] ? glm::distance(scene.points.probe_position_m[probe], scene.points.position_m[i]) : ways[probe][i];
    }
  }
  return path;
}

double stepP99(const SolvedScene& scene, const BlendWeights& w) {
  const float pixel_m = scene.small.lattice.spacing_m / kSlicePixelsACell;
  std::vector<double> steps;
  for (const PointLinks::Link& link : scene.links.links) {
    if (!scene.occluded[link.a] && !scene.occluded[link.b]) continue;
    const bool on_slice = scene.points.use[link.a] == PointUse::slice && scene.points.use[link.b] == PointUse::slice;
    if (on_slice && link.distance_m < 1.1f * pixel_m) steps.push_back(weightChange(scene.points, w, link.a, link.b));
  }
  if (steps.empty()) return 0.0;
  const auto p99 = steps.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(steps.size() - 1));
  std::nth_element(steps.begin(), p99, steps.end());
  return *p99;
}

}  // namespace

double weightChange(const SamplePoints& points, const BlendWeights& w, uint32_t a, uint32_t b) {
  std::array<float, kCornerCount> of_b = w[b];
  double sum = 0.0;
  for (int c = 0; c < kCornerCount; ++c) {
    float there = 0.0f;
    for (int d = 0; d < kCornerCount; ++d) {
      if (points.probe[a][c] >= 0 && points.probe[a][c] == points.probe[b][d]) there = std::exchange(of_b[d], 0.0f);
    }
    sum += std::fabs(w[a][c] - there);
  }
  for (const float left : of_b) sum += left;
  return 0.5 * sum;
}

SolvedScene::SolvedScene(const std::string& name, const SolveSetup& setup)
    : small(makeSmallScene(name)),
      scene(small.makeScene()),
      rays(scene),
      points(makeSamplePoints(small, setup.samples)),
      links(linkPoints(rays, points)),
      light(gatherLight(rays, scene, points, setup.light)),
      table(makeLinkTable(localPoints(points))),
      views(viewProbes(rays, table, points)),
      solved(solveFunctions(points, links, light.fit, setup.solve)) {
  const auto seen = seenCorners(*this);
  path_m = findPaths(*this, seen);
  const BlendWeights tents = points.tent();
  occluded.assign(points.count(), 0);
  for (size_t i = 0; i < points.count(); ++i) {
    for (int c = 0; c < kCornerCount; ++c) occluded[i] |= tents[i][c] >= kOccludedTent && !seen[i][c];
  }
}

Quality judge(const SolvedScene& scene, const BlendWeights& weights, PointUse at) {
  const SamplePoints& points = scene.points;
  const BlendWeights w = normalised(weights);
  const std::vector<float> probes = solveProbes(points, w, scene.light.test, pointsOf(points, {PointUse::fit}));
  const std::vector<double> errors = squaredErrors(points, w, probes, scene.light.test);
  double all = 0.0, occluded = 0.0, unlit = 0.0, leak = 0.0, distance = 0.0;
  size_t count = 0, occluded_count = 0, pair_count = 0;
  for (size_t i = 0; i < points.count(); ++i) {
    if (points.use[i] != at) continue;
    ++count;
    all += errors[i];
    if (!scene.occluded[i]) continue;
    ++occluded_count;
    occluded += errors[i];
    float sum = 0.0f;
    for (int c = 0; c < kCornerCount; ++c) {
      if (points.probe[i][c] < 0) continue;
      sum += w[i][c];
      if (scene.path_m[i][c] > kWayLimit_m) leak += w[i][c];
      const double difference = w[i][c] - scene.solved.weights[i][c];
      distance += difference * difference;
      ++pair_count;
    }
    unlit += sum == 0.0f;
  }
  const auto mean = [](double sum, size_t n) { return n > 0 ? sum / static_cast<double>(n) : 0.0; };
  return {std::sqrt(mean(all, count)), std::sqrt(mean(occluded, occluded_count)),
          mean(unlit, occluded_count), mean(leak, occluded_count),
          stepP99(scene, w),           std::sqrt(mean(distance, pair_count))};
}

}  // namespace nlg
