#include "scene/scene_size.h"

#include <algorithm>

#include <fmt/format.h>

#include "tool/error.h"

namespace nlg {
namespace {

constexpr double kShortest = 0.1, kLongest = 1e5;           // metres, of the longest side: no level beyond
constexpr double kShort = 0.5, kLong = 5e3, kHigh = 150.0;  // few levels beyond

bool isUsual(const glm::dvec3& size) {
  const double longest = std::max({size.x, size.y, size.z});
  return longest >= kShort && longest <= kLong && size.y <= kHigh;
}

std::string shown(const glm::dvec3& size) { return fmt::format("{:.4g} x {:.4g} x {:.4g} m", size.x, size.y, size.z); }

// The first unit with which the size would be a usual one; what is too large may be in centimetres or millimetres, what is too
// small has often been divided by 100 or 1000.
std::string suggestion(const glm::dvec3& size, double unit_m) {
  for (const double factor : {0.01, 0.001, 100.0, 1000.0}) {
    if (!isUsual(size * factor)) continue;
    const char* const guess = factor == 0.01    ? "if it was made in centimetres, "
                              : factor == 0.001 ? "if it was made in millimetres, "
                                                : "";
    return fmt::format("; {}--unit {:g} makes it {}", guess, unit_m * factor, shown(size * factor));
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
  if (isUsual(size)) return "";
  return fmt::format("at {:g} m a unit it is {}, a size that few levels have{}", unit_m, shown(size), suggestion(size, unit_m));
}

}  // namespace nlg
