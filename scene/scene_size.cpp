#include "scene/scene_size.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "scene/floor_survey.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr double kShortest = 0.1, kLongest = 1e5;           // metres, of the longest side: no level beyond
constexpr double kShort = 0.5, kLong = 5e3, kHigh = 150.0;  // few levels beyond
// Rooms: a cathedral's nave is 40 m high, and none of 24 levels of OpenArena is beyond. Not every scene has any: then triangles tell,
// of which the modeller of a level makes few that are longer.
constexpr double kLow = 0.25, kHighRoom = 40.0, kLongEdge = 40.0;
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

double medianEdge(const Scene& scene) {
  if (scene.triangles.size() < kFewestTriangles) return 0.0;
  std::vector<float> edges;
  for (const glm::uvec3& t : scene.triangles) {
    for (int k = 0; k < 3; ++k) edges.push_back(glm::length(scene.positions[t[k]] - scene.positions[t[(k + 1) % 3]]));
  }
  const auto middle = edges.begin() + static_cast<ptrdiff_t>(edges.size() / 2);
  std::nth_element(edges.begin(), middle, edges.end());
  return *middle;
}

Evidence evidenceOf(const Scene& scene, const glm::dvec3& size) {
  const double ceiling = medianCeiling(surveyFloors(scene)).value_or(0.0f);
  // gaps within a thing are no rooms: those are a good part of a level's height
  return {size, ceiling >= kRoomShare * size.y ? ceiling : 0.0, medianEdge(scene)};
}

std::string shown(const glm::dvec3& size) { return fmt::format("{:.4g} x {:.4g} x {:.4g} m", size.x, size.y, size.z); }

// The first unit with which all of it would be usual; what is too large may be in centimetres or millimetres, what is too small has
// often been divided by 100 or 1000.
std::string suggestion(const Evidence& evidence, double unit_m) {
  for (const double factor : {0.01, 0.001, 100.0, 1000.0}) {
    if (!isUsual(evidence * factor)) continue;
    const char* const guess = factor == 0.01    ? "if it was made in centimetres, "
                              : factor == 0.001 ? "if it was made in millimetres, "
                                                : "";
    return fmt::format("; {}--unit {:g} makes it {}", guess, unit_m * factor, shown(evidence.size * factor));
  }
  return "; --unit says how many metres a unit of the file has";
}

}  // namespace

std::string sizeNote(const Scene& scene, const std::string& path, double unit_m) {
  if (scene.triangles.empty()) return "";
  const Bounds bounds = sceneBounds(scene);
  const glm::dvec3 size = glm::dvec3(bounds.max) - glm::dvec3(bounds.min);
  const double longest = std::max({size.x, size.y, size.z});
  if (!(longest >= kShortest && longest <= kLongest)) {
    throw InputError(path, "longest side", fmt::format("0.1 to 100000 m at {:g} m a unit (--unit)", unit_m),
                     fmt::format("{:g} m", longest));
  }
  const Evidence evidence = evidenceOf(scene, size);
  if (isUsual(evidence)) return "";
  std::string what = "a size";
  if (!isUsualRoom(evidence)) {
    what = evidence.ceiling > 0.0 ? fmt::format("with rooms that are {:.3g} m high, a size", evidence.ceiling)
                                  : fmt::format("with triangles of {:.3g} m, a size", evidence.edge);
  }
  return fmt::format("at {:g} m a unit it is {}, {} that few levels have{}", unit_m, shown(size), what,
                     suggestion(evidence, unit_m));
}

}  // namespace nlg
