#include "validate/light/colour_difference.h"

#include <cmath>

namespace nlg {
namespace {

float labCurve(float share) {
  constexpr float kBreak = 216.0f / 24389.0f, kSlope = 24389.0f / 27.0f;
  return share > kBreak ? std::cbrt(share) : (kSlope * share + 16.0f) / 116.0f;
}

}  // namespace

glm::vec3 labOf(const glm::vec3& linear_rgb) {
  const glm::vec3 rgb = glm::clamp(linear_rgb, glm::vec3(0.0f), glm::vec3(1.0f));
  // each row over its own sum: shares of the white point
  const float x = labCurve((0.4124564f * rgb.r + 0.3575761f * rgb.g + 0.1804375f * rgb.b) / 0.9504700f);
  const float y = labCurve((0.2126729f * rgb.r + 0.7151522f * rgb.g + 0.0721750f * rgb.b) / 1.0000001f);
  const float z = labCurve((0.0193339f * rgb.r + 0.1191920f * rgb.g + 0.9503041f * rgb.b) / 1.0888300f);
  return {116.0f * y - 16.0f, 500.0f * (x - y), 200.0f * (y - z)};
}

float hyAb(const glm::vec3& lab_a, const glm::vec3& lab_b) {
  const glm::vec3 d = lab_a - lab_b;
  return std::fabs(d.x) + std::sqrt(d.y * d.y + d.z * d.z);
}

}  // namespace nlg
