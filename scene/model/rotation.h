// Rotation about the vertical axis, with the same bits on every machine (unlike libm's sine and cosine).
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include <glm/glm.hpp>

namespace nlg {

struct Turn {
  double cosine = 1.0;
  double sine = 0.0;
};

// The turn by an angle of any size; exact at multiples of 90 degrees, within 1e-12 elsewhere.
inline Turn turnByDegrees(double degrees) {
  const double quarters = std::floor(degrees / 90.0 + 0.5);
  const double angle = (degrees - 90.0 * quarters) * (std::numbers::pi / 180.0);
  const double square = angle * angle;
  // Taylor series: |angle| <= pi/4 leaves an error below 1e-13 after the terms named here
  double sine = 0.0;
  double cosine = 0.0;
  for (int k = 13; k >= 1; k -= 2) sine = (1.0 - sine * square / ((k + 1.0) * (k + 2.0)));
  for (int k = 12; k >= 0; k -= 2) cosine = (1.0 - cosine * square / ((k + 1.0) * (k + 2.0)));
  sine *= angle;
  switch (static_cast<int64_t>(quarters) & 3) {
    case 0:
      return {cosine, sine};
    case 1:
      return {-sine, cosine};
    case 2:
      return {-cosine, -sine};
    default:
      return {sine, -cosine};
  }
}

// Counter-clockwise as seen from above: +x turns towards -z.
inline glm::dvec3 turned(const Turn& turn, const glm::dvec3& p) {
  return {turn.cosine * p.x + turn.sine * p.z, p.y, turn.cosine * p.z - turn.sine * p.x};
}

}  // namespace nlg
