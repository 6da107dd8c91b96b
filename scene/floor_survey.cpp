#include "scene/floor_survey.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

constexpr size_t kFloors = 512;
constexpr size_t kNotable = 3;  // floors, of all: fewer may be the edge of a wall
constexpr float kUpward = 0.7f;
constexpr float kTouch = 1e-4f;  // of the scene's longest side: what is nearer is the same surface
constexpr float kHeadroom = 2.5f, kStep = 1.5f;
constexpr uint64_t kFloorStream = 0x666c6f6f72;

struct Corners {
  glm::vec3 a, b, c;
  glm::vec3 cross() const { return glm::cross(b - a, c - a); }
};

Corners cornersOf(const std::vector<glm::vec3>& positions, const glm::uvec3& t) {
  return {positions[t.x], positions[t.y], positions[t.z]};
}

float longestSide(const Scene& scene) {
  const Bounds bounds = sceneBounds(scene);
  const glm::vec3 side = bounds.max - bounds.min;
  return std::max({side.x, side.y, side.z});
}

// Twice the area of a triangle that faces up, else 0.
float floorArea(const Scene& scene, size_t t) {
  const glm::vec3 cross = cornersOf(scene.positions, scene.triangles[t]).cross();
  const float length = glm::length(cross);
  const float up = scene.materials[scene.triangle_material[t]].double_sided ? std::fabs(cross.y) : cross.y;
  return up > kUpward * length ? length : 0.0f;
}

// The height of a triangle over a place of the plan; false where it is elsewhere.
bool heightAt(const Corners& t, float x, float z, float* height) {
  const float ux = t.b.x - t.a.x, uz = t.b.z - t.a.z, vx = t.c.x - t.a.x, vz = t.c.z - t.a.z;
  const float area = ux * vz - uz * vx;
  if (area == 0.0f) return false;
  const float px = x - t.a.x, pz = z - t.a.z;
  const float u = (px * vz - pz * vx) / area, v = (ux * pz - uz * px) / area;
  if (!(u >= 0.0f && v >= 0.0f && u + v <= 1.0f)) return false;
  *height = t.a.y + u * (t.b.y - t.a.y) + v * (t.c.y - t.a.y);
  return true;
}

// Calls visit(floor, height) for every one of the floors, sorted by x, that the triangle is above or below.
template <class Visit>
void forEachOver(std::vector<Floor>& floors, const Corners& t, const Visit& visit) {
  const float low = std::min({t.a.x, t.b.x, t.c.x}), high = std::max({t.a.x, t.b.x, t.c.x});
  auto floor = std::lower_bound(floors.begin(), floors.end(), low, [](const Floor& f, float x) { return f.position.x < x; });
  float height = 0.0f;
  for (; floor != floors.end() && floor->position.x <= high; ++floor) {
    if (heightAt(t, floor->position.x, floor->position.z, &height)) visit(*floor, height);
  }
}

std::vector<Floor> placesOnFloors(const Scene& scene) {
  double all = 0.0;
  for (size_t t = 0; t < scene.triangles.size(); ++t) all += floorArea(scene, t);
  std::vector<Floor> floors;
  double before = 0.0;
  for (size_t t = 0; t < scene.triangles.size() && all > 0.0; ++t) {
    before += floorArea(scene, t);
    while (floors.size() < kFloors && (static_cast<double>(floors.size()) + 0.5) / kFloors * all < before) {
      Random random(mixSeed(kFloorStream, floors.size()));
      const auto root = static_cast<float>(std::sqrt(random.uniform())), part = static_cast<float>(random.uniform());
      const auto [a, b, c] = cornersOf(scene.positions, scene.triangles[t]);
      floors.push_back({a * (1.0f - root) + b * (root * (1.0f - part)) + c * (root * part)});
    }
  }
  std::sort(floors.begin(), floors.end(), [](const Floor& a, const Floor& b) { return a.position.x < b.position.x; });
  return floors;
}

}  // namespace

std::vector<Floor> surveyFloors(const Scene& scene) {
  std::vector<Floor> floors = placesOnFloors(scene);
  const float touch = kTouch * longestSide(scene);
  const auto closeAbove = [&](Floor& floor, float height) {
    if (height > floor.position.y + touch) floor.ceiling_m = std::min(floor.ceiling_m, height - floor.position.y);
  };
  for (size_t t = 0; t < scene.triangles.size(); ++t) {
    forEachOver(floors, cornersOf(scene.positions, scene.triangles[t]), [&](Floor& floor, float height) {
      closeAbove(floor, height);
      if (height < floor.position.y - touch) floor.depth_m = std::max(floor.depth_m, floor.position.y - height);
    });
  }
  for (const glm::uvec3& t : scene.light.sky_faces.triangles)
    forEachOver(floors, cornersOf(scene.light.sky_faces.positions, t), closeAbove);
  return floors;
}

std::optional<float> medianCeiling(const std::vector<Floor>& floors) {
  std::vector<float> heights;
  for (const Floor& floor : floors) {
    if (floor.ceiling_m != Floor::kNone) heights.push_back(floor.ceiling_m);
  }
  if (heights.empty() || 4 * heights.size() < floors.size()) return std::nullopt;
  const auto middle = heights.begin() + static_cast<ptrdiff_t>(heights.size() / 2);
  std::nth_element(heights.begin(), middle, heights.end());
  return *middle;
}

std::optional<ExtentBox> reachBeyondBounds(const Scene& scene, double margin_m) {
  const Bounds bounds = sceneBounds(scene);
  glm::vec3 low = bounds.min, high = bounds.max;
  const float longest = longestSide(scene);
  for (const Lamp& lamp : scene.light.lamps) {
    const glm::vec3 away = glm::max(glm::max(bounds.min - lamp.position, lamp.position - bounds.max), glm::vec3(0.0f));
    if (glm::length(away) > longest) continue;
    low = glm::min(low, lamp.position);
    high = glm::max(high, lamp.position);
  }
  // the highest of either kind, but for what is too small to count
  std::vector<float> ground, other;
  for (const Floor& floor : surveyFloors(scene)) {
    if (floor.ceiling_m != Floor::kNone) continue;
    (floor.depth_m <= kStep ? ground : other).push_back(floor.position.y);
  }
  const auto notableTop = [](std::vector<float>& heights) {
    if (heights.size() < kNotable) return -std::numeric_limits<float>::infinity();
    std::nth_element(heights.begin(), heights.begin() + (kNotable - 1), heights.end(), std::greater<>());
    return heights[kNotable - 1];
  };
  high.y = std::max({high.y, notableTop(ground) + kHeadroom, notableTop(other) + static_cast<float>(margin_m)});
  if (low == bounds.min && high == bounds.max) return std::nullopt;
  return ExtentBox{scene.origin_m + glm::dvec3(low), scene.origin_m + glm::dvec3(high)};
}

}  // namespace nlg
