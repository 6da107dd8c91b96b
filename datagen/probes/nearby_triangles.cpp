#include "datagen/probes/nearby_triangles.h"

#include <algorithm>

namespace nlg {
namespace {

constexpr uint32_t kLeafSize = 4;

// Squared distance of two boxes; it never falls when either shrinks, in rounded arithmetic too.
double boxDistance2(const glm::dvec3& low, const glm::dvec3& high, const Bounds& bounds) {
  const glm::dvec3 gap = glm::max(glm::max(glm::dvec3(bounds.min) - high, low - glm::dvec3(bounds.max)), glm::dvec3(0.0));
  return gap.x * gap.x + gap.y * gap.y + gap.z * gap.z;
}

double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

Bounds triangleBounds(const Scene& scene, const glm::uvec3& triangle) {
  const glm::vec3 &a = scene.positions[triangle.x], &b = scene.positions[triangle.y], &c = scene.positions[triangle.z];
  return {glm::min(glm::min(a, b), c), glm::max(glm::max(a, b), c)};
}

}  // namespace

NearbyTriangles::NearbyTriangles(const Scene& scene) : scene_(scene) {
  for (uint32_t t = 0; t < scene.triangles.size(); ++t) {
    const bool is_thin =
        !scene.triangle_material.empty() && scene.materials[scene.triangle_material[t]].transmissive == Transmissive::thin;
    if (!is_thin) order_.push_back(t);
  }
  if (order_.empty()) return;
  nodes_.resize(1);
  std::vector<Range> open{{0, 0, static_cast<uint32_t>(order_.size())}};
  while (!open.empty()) {
    const Range range = open.back();
    open.pop_back();
    split(range, open);
  }
}

// Halves by count, along the longest side of the boxes' centres.
void NearbyTriangles::split(const Range& range, std::vector<Range>& open) {
  const auto first = order_.begin() + range.first;
  // box of the triangles, and box of their centres: the second says where they can be parted
  Bounds bounds = triangleBounds(scene_, scene_.triangles[*first]);
  const auto centre2 = [&](uint32_t t) {
    const Bounds b = triangleBounds(scene_, scene_.triangles[t]);
    return glm::dvec3(b.min) + glm::dvec3(b.max);
  };
  glm::dvec3 low = centre2(*first), high = low;
  for (auto t = first; t != first + range.count; ++t) {
    const Bounds b = triangleBounds(scene_, scene_.triangles[*t]);
    bounds = {glm::min(bounds.min, b.min), glm::max(bounds.max, b.max)};
    low = glm::min(low, centre2(*t));
    high = glm::max(high, centre2(*t));
  }
  nodes_[range.node_idx] = {bounds, range.first, range.count};
  // halves by count: depth stays logarithmic however triangles cluster
  if (range.count <= kLeafSize) return;
  const glm::dvec3 side = high - low;
  const int axis = side.x >= side.y && side.x >= side.z ? 0 : side.y >= side.z ? 1 : 2;
  const uint32_t half = range.count / 2;
  std::nth_element(first, first + half, first + range.count,
                   [&](uint32_t a, uint32_t b) { return centre2(a)[axis] < centre2(b)[axis]; });
  // an inner node has no triangles: first is then its first child, the second follows
  const auto child = static_cast<uint32_t>(nodes_.size());
  nodes_[range.node_idx].first = child;
  nodes_[range.node_idx].count = 0;
  nodes_.resize(child + 2);
  open.push_back({child, range.first, half});
  open.push_back({child + 1, range.first + half, range.count - half});
}

bool NearbyTriangles::anyCloser(const glm::dvec3& low_m, const glm::dvec3& high_m, double distance_m) const {
  if (nodes_.empty()) return false;
  const glm::dvec3 centre = 0.5 * (low_m + high_m), half = 0.5 * (high_m - low_m);
  const double limit2 = distance_m * distance_m;
  uint32_t open[64] = {0};  // halving 2^32 triangles, at most one sibling waits a level
  for (int count = 1; count > 0;) {
    const Node& node = nodes_[open[--count]];
    if (!(boxDistance2(low_m, high_m, node.bounds) < limit2)) continue;
    if (node.count == 0) {
      open[count++] = node.first;
      open[count++] = node.first + 1;
    }
    for (uint32_t i = node.first; i < node.first + node.count; ++i) {
      const glm::uvec3& triangle = scene_.triangles[order_[i]];
      if (boxDistance2(low_m, high_m, triangleBounds(scene_, triangle)) < limit2 && isCloser(triangle, centre, half, distance_m))
        return true;
    }
  }
  return false;
}

// Box and triangle are as far apart as their shadows on any line; the lines tried are the triangle's normal and the products of
// its edges with the box's (the separating axes of the two; the box's own are in boxDistance2).
bool NearbyTriangles::isCloser(const glm::uvec3& triangle, const glm::dvec3& centre, const glm::dvec3& half,
                               double distance_m) const {
  // everything relative to the box: its own reach along a line is half . |line|
  const glm::dvec3 corners[3] = {glm::dvec3(scene_.positions[triangle.x]) - centre,
                                 glm::dvec3(scene_.positions[triangle.y]) - centre,
                                 glm::dvec3(scene_.positions[triangle.z]) - centre};
  const auto isApart = [&](const glm::dvec3& line) {
    const double a = dot(line, corners[0]), b = dot(line, corners[1]), c = dot(line, corners[2]);
    const double reach = dot(half, glm::abs(line));
    const double gap = std::max(std::min({a, b, c}) - reach, -std::max({a, b, c}) - reach);
    return gap > 0.0 && gap * gap >= distance_m * distance_m * dot(line, line);
  };
  // the triangle's plane
  const glm::dvec3 edges[3] = {corners[1] - corners[0], corners[2] - corners[1], corners[0] - corners[2]};
  if (isApart(glm::cross(edges[0], edges[1]))) return false;
  // its edges with the axes of the box
  for (const glm::dvec3& edge : edges) {
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 unit(0.0);
      unit[axis] = 1.0;
      if (isApart(glm::cross(edge, unit))) return false;
    }
  }
  return true;
}

}  // namespace nlg
