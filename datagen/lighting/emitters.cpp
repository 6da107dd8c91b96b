#include "datagen/lighting/emitters.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

constexpr uint32_t kNone = ~0u;
constexpr size_t kMostClusters = 64;  // a place weighs them all: about as long as a ray takes

glm::vec3 crossOf(const Scene& scene, uint32_t triangle) {
  const glm::uvec3& t = scene.triangles[triangle];
  return glm::cross(scene.positions[t.y] - scene.positions[t.x], scene.positions[t.z] - scene.positions[t.x]);
}

glm::vec3 middleOf(const Scene& scene, uint32_t triangle) {
  const glm::uvec3& t = scene.triangles[triangle];
  return (scene.positions[t.x] + scene.positions[t.y] + scene.positions[t.z]) / 3.0f;
}

// Halves the widest range again and again: neighbours stay together.
std::vector<std::vector<uint32_t>> clustersOf(const Scene& scene, std::vector<uint32_t> triangles) {
  struct Range {
    std::vector<uint32_t> triangles;
    glm::vec3 size{0.0f};
  };
  const auto measured = [&](std::vector<uint32_t> members) {
    glm::vec3 low = middleOf(scene, members.front()), high = low;
    for (const uint32_t t : members) {
      low = glm::min(low, middleOf(scene, t));
      high = glm::max(high, middleOf(scene, t));
    }
    return Range{std::move(members), high - low};
  };
  const auto width = [](const Range& range) { return std::max({range.size.x, range.size.y, range.size.z}); };
  std::vector<Range> ranges;
  ranges.push_back(measured(std::move(triangles)));
  while (ranges.size() < kMostClusters) {
    const auto widest =
        std::max_element(ranges.begin(), ranges.end(), [&](const Range& a, const Range& b) { return width(a) < width(b); });
    if (!(width(*widest) > 0.0f)) break;
    const int axis = widest->size.x == width(*widest) ? 0 : widest->size.y == width(*widest) ? 1 : 2;
    std::vector<uint32_t> members = std::move(widest->triangles);
    const auto half = members.begin() + static_cast<ptrdiff_t>(members.size() / 2);
    std::nth_element(members.begin(), half, members.end(), [&](uint32_t a, uint32_t b) {
      const float at_a = middleOf(scene, a)[axis], at_b = middleOf(scene, b)[axis];
      return at_a != at_b ? at_a < at_b : a < b;
    });
    *widest = measured({members.begin(), half});
    ranges.push_back(measured({half, members.end()}));
  }
  std::vector<std::vector<uint32_t>> clusters;
  for (Range& range : ranges) {
    std::sort(range.triangles.begin(), range.triangles.end());
    clusters.push_back(std::move(range.triangles));
  }
  return clusters;
}

}  // namespace

float Emitters::luminance(uint32_t triangle) const {
  const glm::vec3& rgb = scene_.materials[scene_.triangle_material[triangle]].emissive;
  return 0.2126f * rgb.r + 0.7152f * rgb.g + 0.0722f * rgb.b;
}

Emitters::Emitters(const Scene& scene) : scene_(scene) {
  std::vector<uint32_t> shining;
  for (uint32_t t = 0; t < scene.triangles.size(); ++t) {
    if (luminance(t) * glm::length(crossOf(scene, t)) > 0.0f) shining.push_back(t);
  }
  if (shining.empty()) return;
  cluster_of_.assign(scene.triangles.size(), kNone);
  for (const std::vector<uint32_t>& members : clustersOf(scene, std::move(shining))) {
    Cluster cluster;
    cluster.first = static_cast<uint32_t>(triangles_.size());
    cluster.count = static_cast<uint32_t>(members.size());
    for (const uint32_t t : members) {
      cluster.power += 0.5f * glm::length(crossOf(scene, t)) * luminance(t);
      cluster.middle += middleOf(scene, t) / static_cast<float>(members.size());
      cluster_of_[t] = static_cast<uint32_t>(clusters_.size());
      triangles_.push_back(t);
      sums_.push_back(cluster.power);
    }
    for (const uint32_t t : members) {
      for (int k = 0; k < 3; ++k) {
        const glm::vec3 way = scene.positions[scene.triangles[t][k]] - cluster.middle;
        cluster.radius_squared = std::max(cluster.radius_squared, glm::dot(way, way));
      }
    }
    clusters_.push_back(cluster);
  }
}

float Emitters::reach(const Cluster& cluster, const glm::vec3& from) {
  const glm::vec3 way = from - cluster.middle;
  return cluster.power / std::max(glm::dot(way, way), cluster.radius_squared);
}

EmitterPoint Emitters::draw(const glm::vec3& from, Random& random) const {
  float total = 0.0f;
  for (const Cluster& cluster : clusters_) total += reach(cluster, from);
  float at = static_cast<float>(random.uniform()) * total;
  const Cluster* chosen = &clusters_.back();
  for (const Cluster& cluster : clusters_) {
    chosen = &cluster;
    if ((at -= reach(cluster, from)) < 0.0f) break;
  }
  const auto first = sums_.begin() + chosen->first, end = first + chosen->count;
  const auto found = std::upper_bound(first, end, static_cast<float>(random.uniform()) * chosen->power);
  const auto index = static_cast<size_t>(std::min(found - sums_.begin(), end - sums_.begin() - 1));
  EmitterPoint point;
  point.triangle = triangles_[index];
  point.area_density = reach(*chosen, from) / total * luminance(point.triangle) / chosen->power;
  auto u = static_cast<float>(random.uniform()), v = static_cast<float>(random.uniform());
  if (u + v > 1.0f) {
    u = 1.0f - u;
    v = 1.0f - v;
  }
  const glm::uvec3& t = scene_.triangles[point.triangle];
  point.position = scene_.positions[t.x] * (1.0f - u - v) + scene_.positions[t.y] * u + scene_.positions[t.z] * v;
  return point;
}

float Emitters::areaDensity(uint32_t triangle, const glm::vec3& from) const {
  if (cluster_of_.empty() || cluster_of_[triangle] == kNone) return 0.0f;
  float total = 0.0f;
  for (const Cluster& cluster : clusters_) total += reach(cluster, from);
  const Cluster& own = clusters_[cluster_of_[triangle]];
  return reach(own, from) / total * luminance(triangle) / own.power;
}

}  // namespace nlg
