#include "scene/solid/free_standing.h"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "scene/solid/closed_shells.h"

namespace nlg {
namespace {

// Volume that the faces enclose towards the box's centre, as a share of the box: 1 for a whole box that looks outward, 5/6
// without one side, 0 for a sheet, negative for a room.
constexpr double kOutwardShare = 0.5;
constexpr double kOpenShare = 0.05;  // of the edges' length: below, a component counts as closed

constexpr double kLargestSide_m = 12.0;  // a level that was compiled with a leak holds rooms with thick walls, closed all round

bool isFreeStanding(const Shell& shell) {
  const glm::dvec3 size = shell.high - shell.low;
  if (std::max({size.x, size.y, size.z}) > kLargestSide_m) return false;
  const bool is_closed = shell.open_length_m <= kOpenShare * shell.edge_length_m;
  return shell.volume_m3 > 0.0 && (shell.volume_m3 > kOutwardShare * size.x * size.y * size.z || is_closed);
}

}  // namespace

void splitFreeStanding(Scene& scene, size_t object_idx) {
  // only this one is split: what is not movable stays whole
  std::vector<bool> was_movable;
  for (SceneObject& object : scene.objects) was_movable.push_back(std::exchange(object.movable, false));
  const size_t behind = scene.objects.size() - object_idx - 1;
  scene.objects[object_idx].movable = true;
  splitConnectedComponents(scene, 1.0);
  ShellFinder finder(weldedVertices(scene.positions));
  for (size_t i = object_idx; i + behind < scene.objects.size(); ++i) {
    SceneObject& object = scene.objects[i];
    const std::span triangles(scene.triangles.data() + object.first_triangle, object.triangle_count);
    object.movable = isFreeStanding(finder.measure(scene.positions, triangles, finder.components(triangles))[0]);
  }
  for (size_t i = 0; i < object_idx; ++i) scene.objects[i].movable = was_movable[i];
  for (size_t i = 0; i < behind; ++i) scene.objects[scene.objects.size() - behind + i].movable = was_movable[object_idx + 1 + i];
}

}  // namespace nlg
