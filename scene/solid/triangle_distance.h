// Distance from a point to a triangle.
#pragma once

#include <glm/glm.hpp>

namespace nlg {

// a, b, c   the triangle's corners, of which none need differ
float distanceToTriangle(const glm::vec3& point, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c);

}  // namespace nlg
