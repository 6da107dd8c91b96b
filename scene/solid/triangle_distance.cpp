#include "scene/solid/triangle_distance.h"

#include <algorithm>
#include <cmath>

namespace nlg {
namespace {

float distanceToSegment(const glm::vec3& point, const glm::vec3& from, const glm::vec3& to) {
  const glm::vec3 along = to - from;
  const float length_squared = glm::dot(along, along);
  if (!(length_squared > 0.0f)) return glm::distance(point, from);
  const float share = std::clamp(glm::dot(point - from, along) / length_squared, 0.0f, 1.0f);
  return glm::distance(point, from + share * along);
}

}  // namespace

float distanceToTriangle(const glm::vec3& point, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  const glm::vec3 normal = glm::cross(b - a, c - a);
  const float area_squared = glm::dot(normal, normal);
  const float to_rim = std::min({distanceToSegment(point, a, b), distanceToSegment(point, b, c), distanceToSegment(point, c, a)});
  if (!(area_squared > 0.0f)) return to_rim;
  const auto isInside = [&](const glm::vec3& from, const glm::vec3& to) {
    return glm::dot(glm::cross(to - from, point - from), normal) >= 0.0f;
  };
  if (!isInside(a, b) || !isInside(b, c) || !isInside(c, a)) return to_rim;
  return std::fabs(glm::dot(point - a, normal)) / std::sqrt(area_squared);
}

}  // namespace nlg
