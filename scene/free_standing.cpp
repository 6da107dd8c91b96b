#include "scene/free_standing.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <utility>

namespace nlg {
namespace {

// Volume that the faces enclose towards the box's centre, as a share of the box: 1 for a whole box that looks outward, 5/6
// without one side, 0 for a sheet, negative for a room.
constexpr double kOutwardShare = 0.5;
constexpr double kOpenShare = 0.05;  // of the edges' length: below, a component counts as closed

constexpr double kLargestSide_m = 12.0;  // a level that was compiled with a leak holds rooms with thick walls, closed all round

using PointBits = std::array<uint32_t, 3>;

PointBits bitsOf(const glm::vec3& p) {
  return {std::bit_cast<uint32_t>(p.x), std::bit_cast<uint32_t>(p.y), std::bit_cast<uint32_t>(p.z)};
}

bool isClosed(const Scene& scene, const SceneObject& object) {
  // length of every edge, signed by its direction: those of two faces that meet along it cancel
  std::map<std::pair<PointBits, PointBits>, double> open_length;
  double total = 0.0;
  for (uint32_t i = object.first_triangle; i < object.first_triangle + object.triangle_count; ++i) {
    for (int k = 0; k < 3; ++k) {
      const glm::vec3& a = scene.positions[scene.triangles[i][k]];
      const glm::vec3& b = scene.positions[scene.triangles[i][(k + 1) % 3]];
      const double length = glm::length(glm::dvec3(b) - glm::dvec3(a));
      const PointBits from = bitsOf(a), to = bitsOf(b);
      open_length[std::minmax(from, to)] += from < to ? length : -length;
      total += length;
    }
  }
  double open = 0.0;
  for (const auto& [edge, length] : open_length) open += std::abs(length);
  return open <= kOpenShare * total;
}

bool isFreeStanding(const Scene& scene, const SceneObject& object) {
  const Bounds bounds = objectBounds(scene, object);
  const glm::dvec3 centre = 0.5 * (glm::dvec3(bounds.min) + glm::dvec3(bounds.max));
  const glm::dvec3 size = glm::dvec3(bounds.max) - glm::dvec3(bounds.min);
  if (std::max({size.x, size.y, size.z}) > kLargestSide_m) return false;
  double volume = 0.0;
  for (uint32_t i = object.first_triangle; i < object.first_triangle + object.triangle_count; ++i) {
    glm::dvec3 p[3];
    for (int k = 0; k < 3; ++k) p[k] = glm::dvec3(scene.positions[scene.triangles[i][k]]) - centre;
    volume += glm::dot(p[0], glm::cross(p[1], p[2])) / 6.0;
  }
  const double box = size.x * size.y * size.z;
  return volume > 0.0 && (volume > kOutwardShare * box || isClosed(scene, object));
}

}  // namespace

void splitFreeStanding(Scene& scene, size_t object_idx) {
  // only this one is split: what is not movable stays whole
  std::vector<bool> was_movable;
  for (SceneObject& object : scene.objects) was_movable.push_back(std::exchange(object.movable, false));
  const size_t behind = scene.objects.size() - object_idx - 1;
  scene.objects[object_idx].movable = true;
  splitConnectedComponents(scene, 1.0);
  for (size_t i = object_idx; i + behind < scene.objects.size(); ++i) {
    scene.objects[i].movable = isFreeStanding(scene, scene.objects[i]);
  }
  for (size_t i = 0; i < object_idx; ++i) scene.objects[i].movable = was_movable[i];
  for (size_t i = 0; i < behind; ++i) scene.objects[scene.objects.size() - behind + i].movable = was_movable[object_idx + 1 + i];
}

}  // namespace nlg
