// A pinhole camera.
#pragma once

#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "light/light_transport.h"

namespace nlg {

struct Camera {
  glm::dvec3 eye_m{0.0};                 // relative to the scene's origin
  glm::vec3 forward{0.0f, 0.0f, -1.0f};  // unit
  glm::vec3 up{0.0f, 1.0f, 0.0f};        // unit, at a right angle to forward
  double fov_y = 1.0472;                 // radians from the picture's lower to its upper edge, in (0, pi)

  // Of the ray through a place of the picture, unit. x from the left, y from the top, both in [0, 1] inside the picture
  // aspect   width over height
  glm::vec3 direction(double x, double y, double aspect) const;

  // Where a point is seen: x and y of direction(). Nothing of what is not before the camera.
  // point_m   relative to the scene's origin
  std::optional<glm::dvec2> seenAt(const glm::dvec3& point_m, double aspect) const;
};

// A camera at eye_m that looks along a direction, upright: what is up in the world is up in the picture. Along the vertical, -z is.
// direction   not 0
Camera cameraAlong(const glm::dvec3& eye_m, const glm::dvec3& direction, double fov_y);

// Twelve evenly around an eye, somewhat downwards: floors are lit, skies are not looked at.
inline constexpr int kTurnCount = 12;
Camera cameraTurned(const glm::dvec3& eye_m, int turn, double fov_y);

// Surfaces by material and the way they face, in 27 ways: a wall counts once, however many triangles it has.
uint32_t surfaceSide(const Scene& scene, const LightHit& hit);

// A view of a scene for those who name none.
//
// Looks from a place in air to where there is much to see: far and near, many sides of surfaces, no backs of them, little sky, and
// some light. The same view for the same scene and seed.
// throws   InputError when no place in air was found
Camera chooseView(const LightTransport& transport, double fov_y, double aspect, uint64_t seed);

// The same from one of these eyes, in the first of twelve directions around it that shows most.
// eyes_m   in air, at least one
Camera bestView(const LightTransport& transport, const std::vector<glm::dvec3>& eyes_m, double fov_y, double aspect);

}  // namespace nlg
