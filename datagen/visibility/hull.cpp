#include "datagen/visibility/hull.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace nlg {
namespace {

constexpr int kRays = 64, kRaysOfPlace = 1000;
constexpr double kCracks = 1.0 / 250.0;
constexpr size_t kMostPlaces = 64;  // evenly from all

// A spiral that covers the sphere evenly.
std::vector<glm::vec3> evenDirections(int count) {
  std::vector<glm::vec3> directions;
  for (int i = 0; i < count; ++i) {
    const double y = 1.0 - (2.0 * i + 1.0) / count, turn = i * std::numbers::pi * (3.0 - std::sqrt(5.0)),
                 radius = std::sqrt(1.0 - y * y);
    directions.emplace_back(radius * std::cos(turn), y, radius * std::sin(turn));
  }
  return directions;
}

bool leaves(const RayScene& rays, const glm::vec3& place, const glm::vec3& direction) {
  return rays.lightHit(place, direction).kind == LightHit::Kind::nothing;
}

bool closesOff(const RayScene& rays, const std::vector<glm::vec3>& places) {
  const std::vector<glm::vec3> directions = evenDirections(kRaysOfPlace);
  const size_t step = (places.size() + kMostPlaces - 1) / kMostPlaces;
  for (size_t i = 0; i < places.size(); i += step) {
    const auto out =
        std::count_if(directions.begin(), directions.end(), [&](const glm::vec3& d) { return leaves(rays, places[i], d); });
    if (static_cast<double>(out) > kCracks * kRaysOfPlace) return false;
  }
  return !places.empty();
}

}  // namespace

Hull::Hull(const RayScene& rays, const std::vector<glm::vec3>& places)
    : rays_(rays), directions_(evenDirections(kRays)), is_there_(closesOff(rays, places)) {}

bool Hull::holds(const glm::vec3& place) const {
  return std::none_of(directions_.begin(), directions_.end(), [&](const glm::vec3& d) { return leaves(rays_, place, d); });
}

}  // namespace nlg
