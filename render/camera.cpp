#include "render/camera.h"

#include <cmath>

namespace nlg {

glm::vec3 Camera::direction(double x, double y, double aspect) const {
  const double half_height = std::tan(0.5 * fov_y);
  const glm::dvec3 ahead(forward), upwards(up), right = glm::cross(ahead, upwards);
  return glm::vec3(
      glm::normalize(ahead + right * ((2.0 * x - 1.0) * aspect * half_height) + upwards * ((1.0 - 2.0 * y) * half_height)));
}

std::optional<glm::dvec2> Camera::seenAt(const glm::dvec3& point_m, double aspect) const {
  const glm::dvec3 ahead(forward), upwards(up), right = glm::cross(ahead, upwards), way = point_m - eye_m;
  const double depth = glm::dot(way, ahead), half_height = depth * std::tan(0.5 * fov_y);
  if (!(depth > 0.0)) return std::nullopt;
  return glm::dvec2(0.5 + 0.5 * glm::dot(way, right) / (aspect * half_height), 0.5 - 0.5 * glm::dot(way, upwards) / half_height);
}

Camera cameraAlong(const glm::dvec3& eye_m, const glm::dvec3& direction, double fov_y) {
  constexpr double kVertical = 1.0 - 1e-9;
  const glm::dvec3 ahead = glm::normalize(direction);
  const glm::dvec3 about = std::abs(ahead.y) < kVertical ? glm::dvec3(0.0, 1.0, 0.0) : glm::dvec3(0.0, 0.0, -1.0);
  const glm::dvec3 right = glm::normalize(glm::cross(ahead, about));
  return {eye_m, glm::vec3(ahead), glm::vec3(glm::cross(right, ahead)), fov_y};
}

}  // namespace nlg
