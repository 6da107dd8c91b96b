#include "scene/scene_size.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "runtime_eval/numbers/random.h"
#include "tool/error.h"

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

constexpr double kShortest = 0.1, kLongest = 1e5;           // metres, of the longest side: no level beyond
constexpr double kShort = 0.5, kLong = 5e3, kHigh = 150.0;  // few levels beyond
// Rooms: a cathedral's nave is 40 m high, and none of 24 levels of OpenArena is beyond. Not every scene has any: then triangles tell,
// of which the modeller of a level makes few that are longer.
constexpr double kLow = 0.25, kHighRoom = 40.0, kLongEdge = 40.0, kOrdinaryRoom = 2.7;
constexpr double kLowStorey = 2.0, kHighStorey = 5.0;  // no two units a factor of ten apart have both within
constexpr double kRoomShare = 0.05;
constexpr size_t kFewestTriangles = 12;

// What tells of a scene's unit, metres.
struct Evidence {
  glm::dvec3 size{0.0};
  double ceiling = 0.0;  // 0: it has no rooms
  double edge = 0.0;     // of a triangle; 0: too few
};

Evidence operator*(const Evidence& e, double factor) { return {e.size * factor, e.ceiling * factor, e.edge * factor}; }

bool isUsualRoom(const Evidence& e) {
  return e.ceiling > 0.0 ? e.ceiling >= kLow && e.ceiling <= kHighRoom : e.edge <= kLongEdge;
}

bool isUsual(const Evidence& e) {
  const double longest = std::max({e.size.x, e.size.y, e.size.z});
  return longest >= kShort && longest <= kLong && e.size.y <= kHigh && isUsualRoom(e);
}

// Of an even number the upper one.
float medianOf(std::vector<float> numbers) {
  const auto middle = numbers.begin() + static_cast<ptrdiff_t>(numbers.size() / 2);
  std::nth_element(numbers.begin(), middle, numbers.end());
  return *middle;
}

double medianEdge(const Scene& scene) {
  if (scene.triangles.size() < kFewestTriangles) return 0.0;
  std::vector<float> edges;
  for (const glm::uvec3& t : scene.triangles) {
    for (int k = 0; k < 3; ++k) edges.push_back(glm::length(scene.positions[t[k]] - scene.positions[t[(k + 1) % 3]]));
  }
  return medianOf(std::move(edges));
}

Evidence evidenceOf(const Scene& scene) {
  const Bounds bounds = sceneBounds(scene);
  const glm::dvec3 size = glm::dvec3(bounds.max) - glm::dvec3(bounds.min);
  const double ceiling = medianCeiling(surveyFloors(scene)).value_or(0.0f);
  // gaps within a thing are no rooms: those are a good part of a level's height
  return {size, ceiling >= kRoomShare * size.y ? ceiling : 0.0, medianEdge(scene)};
}

// What a figure fits into: no unit is named that makes a doll's house of a hall.
bool isWalkable(const Evidence& e) { return std::max({e.size.x, e.size.y, e.size.z}) >= kLowStorey; }

std::string shown(const glm::dvec3& size) { return fmt::format("{:.4g} x {:.4g} x {:.4g} m", size.x, size.y, size.z); }

// The unit with which all of it would be usual, its rooms above all; what is too large may be in centimetres or millimetres, what is too
// small has often been divided by 100 or 1000.
std::string suggestion(const Evidence& evidence, double unit_m) {
  double best = 0.0;
  const auto oddity = [&](double factor) { return std::fabs(std::log(evidence.ceiling * factor / kOrdinaryRoom)); };
  for (const double factor : {0.01, 0.001, 100.0, 1000.0}) {
    if (isUsual(evidence * factor) && isWalkable(evidence * factor) && (best == 0.0 || oddity(factor) < oddity(best)))
      best = factor;
  }
  if (best == 0.0) return "; --unit says how many metres a unit of the file has";
  const char* const guess = best == 0.01    ? "if it was made in centimetres, "
                            : best == 0.001 ? "if it was made in millimetres, "
                                            : "";
  return fmt::format("; {}--unit {:g} makes it {}", guess, unit_m * best, shown(evidence.size * best));
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
  return medianOf(std::move(heights));
}

std::optional<ExtentBox> reachBeyondBounds(const Scene& scene, double margin_m) {
  const Bounds bounds = sceneBounds(scene);
  glm::vec3 low = bounds.min, high = bounds.max;
  const float longest = longestSide(scene);
  // lamps outside the geometry count, unless they are further away than it is long
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
  // headroom above the highest open ground, the margin above other tops
  high.y = std::max({high.y, notableTop(ground) + kHeadroom, notableTop(other) + static_cast<float>(margin_m)});
  if (low == bounds.min && high == bounds.max) return std::nullopt;
  return ExtentBox{scene.origin_m + glm::dvec3(low), scene.origin_m + glm::dvec3(high)};
}

std::string sizeNote(const Scene& scene, const std::string& path, double unit_m) {
  if (scene.triangles.empty()) return "";
  const Bounds bounds = sceneBounds(scene);
  const glm::dvec3 size = glm::dvec3(bounds.max) - glm::dvec3(bounds.min);
  const double longest = std::max({size.x, size.y, size.z});
  if (!(longest >= kShortest && longest <= kLongest)) {
    throw InputError(path, "longest side", fmt::format("0.1 to 100000 m at {:g} m a unit (--unit)", unit_m),
                     fmt::format("{:g} m", longest));
  }
  const Evidence evidence = evidenceOf(scene);
  if (isUsual(evidence)) return "";
  std::string what = "a size";
  if (!isUsualRoom(evidence)) {
    what = evidence.ceiling > 0.0 ? fmt::format("with rooms that are {:.3g} m high, a size", evidence.ceiling)
                                  : fmt::format("with triangles of {:.3g} m, a size", evidence.edge);
  }
  return fmt::format("at {:g} m a unit it is {}, {} that few levels have{}", unit_m, shown(size), what,
                     suggestion(evidence, unit_m));
}

double certainUnit(const Scene& scene) {
  const Evidence evidence = evidenceOf(scene);
  for (const double factor : {0.01, 0.001}) {
    const double storey = evidence.ceiling * factor;
    if (storey >= kLowStorey && storey <= kHighStorey && isUsual(evidence * factor)) return factor;
  }
  return 0.0;
}

}  // namespace nlg
