// Directions from pairs of numbers in [0, 1), and a lattice of such pairs.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include <glm/glm.hpp>

#include "runtime_eval/numbers/random.h"

namespace nlg {

inline constexpr float kPi = std::numbers::pi_v<float>;

// Fibonacci's lattice, shifted by a seed: its points cover the square far more evenly than random ones do, and so does every
// eighth of them.
class Lattice {
 public:
  // index   lattices of one seed whose indices follow one another fill each other's gaps: Roberts's sequence shifts them
  explicit Lattice(uint64_t seed, uint64_t index = 0) {
    Random random(seed);
    const double u = random.uniform() + static_cast<double>(index) * 0.7548776662466927;
    const double v = random.uniform() + static_cast<double>(index) * 0.5698402909980532;
    shift_u_ = u - std::floor(u);
    shift_v_ = v - std::floor(v);
  }
  // i < count
  std::pair<double, double> point(int i, int count) const {
    const double u = (i + shift_u_) / count;
    const double v = i * 0.6180339887498949 + shift_v_;
    return {u, v - std::floor(v)};
  }

 private:
  double shift_u_, shift_v_;
};

// Two directions across `axis` and each other. By Duff and others, "Building an orthonormal basis, revisited" (JCGT 2017).
inline std::pair<glm::vec3, glm::vec3> acrossOf(const glm::vec3& axis) {
  const float sign = std::copysign(1.0f, axis.z);
  const float a = -1.0f / (sign + axis.z), b = axis.x * axis.y * a;
  return {{1.0f + sign * axis.x * axis.x * a, sign * b, -sign * axis.x}, {b, sign + axis.y * axis.y * a, -axis.y}};
}

inline glm::vec3 aroundAxis(const glm::vec3& axis, float cosine, double turn) {
  const float sine = std::sqrt(std::max(0.0f, 1.0f - cosine * cosine));
  const auto angle = static_cast<float>(2.0 * std::numbers::pi * turn);
  const auto [x, y] = acrossOf(axis);
  return glm::normalize(axis * cosine + x * (sine * std::cos(angle)) + y * (sine * std::sin(angle)));
}

// Uniform over the sphere; over the cap around axis whose height is 1 - cosine; by the cosine around a normal.
inline glm::vec3 sphereDirection(double u, double v) {
  return aroundAxis({0.0f, 0.0f, 1.0f}, static_cast<float>(1.0 - 2.0 * u), v);
}
// For weights that look at the normal: any one, the same for the same position.
inline glm::vec3 randomNormal(const glm::dvec3& position) {
  constexpr uint64_t kStream = 0x736f6c7665;
  Random random(mixSeed(std::bit_cast<uint64_t>(position.x), std::bit_cast<uint64_t>(position.y),
                        std::bit_cast<uint64_t>(position.z), kStream));
  const double u = random.uniform(), v = random.uniform();
  return sphereDirection(u, v);
}
inline glm::vec3 coneDirection(const glm::vec3& axis, float cap, double u, double v) {
  // not 1 - u cap squared: a lamp far away keeps its size
  const float height = cap * static_cast<float>(u);
  const float sine = std::sqrt(std::max(0.0f, height * (2.0f - height)));
  const auto angle = static_cast<float>(2.0 * std::numbers::pi * v);
  const auto [x, y] = acrossOf(axis);
  return glm::normalize(axis * (1.0f - height) + x * (sine * std::cos(angle)) + y * (sine * std::sin(angle)));
}
inline glm::vec3 cosineDirection(const glm::vec3& normal, double u, double v) {
  return aroundAxis(normal, static_cast<float>(std::sqrt(1.0 - u)), v);
}

}  // namespace nlg
