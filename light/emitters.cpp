#include "light/emitters.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

constexpr uint32_t kNone = ~0u;

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
  while (ranges.size() < Emitters::kMostClusters) {
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

Emitters::Draws::Draws(const Emitters& emitters, const glm::vec3& from) : emitters_(emitters) {
  float sum = 0.0f;
  for (size_t c = 0; c < emitters.clusters_.size(); ++c) sums_[c] = sum += reach(emitters.clusters_[c], from);
}

float Emitters::Draws::chance(size_t cluster) const {
  const float before = cluster > 0 ? sums_[cluster - 1] : 0.0f;
  return (sums_[cluster] - before) / sums_[emitters_.clusters_.size() - 1];
}

EmitterPoint Emitters::Draws::draw(double u, Random& random) const {
  const auto indexIn = [](const float* first, size_t count, float at) {
    return std::min<size_t>(static_cast<size_t>(std::upper_bound(first, first + count, at) - first), count - 1);
  };
  const size_t count = emitters_.clusters_.size();
  const size_t chosen = indexIn(sums_.data(), count, static_cast<float>(u) * sums_[count - 1]);
  const Cluster& cluster = emitters_.clusters_[chosen];
  const size_t index =
      indexIn(&emitters_.sums_[cluster.first], cluster.count, static_cast<float>(random.uniform()) * cluster.power);
  EmitterPoint point;
  point.triangle = emitters_.triangles_[cluster.first + index];
  point.area_density = areaDensity(point.triangle);
  auto a = static_cast<float>(random.uniform()), b = static_cast<float>(random.uniform());
  if (a + b > 1.0f) {
    a = 1.0f - a;
    b = 1.0f - b;
  }
  const Scene& scene = emitters_.scene_;
  const glm::uvec3& t = scene.triangles[point.triangle];
  point.position = scene.positions[t.x] * (1.0f - a - b) + scene.positions[t.y] * a + scene.positions[t.z] * b;
  return point;
}

float Emitters::Draws::areaDensity(uint32_t triangle) const {
  if (emitters_.empty() || emitters_.cluster_of_[triangle] == kNone) return 0.0f;
  const uint32_t own = emitters_.cluster_of_[triangle];
  return chance(own) * emitters_.luminance(triangle) / emitters_.clusters_[own].power;
}

}  // namespace nlg
