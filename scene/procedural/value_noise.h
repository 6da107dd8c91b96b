// Smooth noise over space from a seed; sums and products only, so the same bits on every machine.
#pragma once

#include <cmath>
#include <cstdint>

#include <glm/glm.hpp>

#include "runtime_eval/numbers/random.h"

namespace nlg {

// Random values at whole numbers, blended smoothly in between; in [-1, 1], one lattice cell a unit.
inline double valueNoise(uint64_t seed, const glm::dvec3& p) {
  const glm::dvec3 cell(std::floor(p.x), std::floor(p.y), std::floor(p.z));
  const glm::dvec3 t = p - cell;
  const glm::dvec3 blend = t * t * (glm::dvec3(3.0) - 2.0 * t);
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::ivec3 bit(corner & 1, corner >> 1 & 1, corner >> 2);
    const auto lattice = [&](int axis) { return static_cast<uint64_t>(static_cast<int64_t>(cell[axis]) + bit[axis]); };
    const uint64_t hash = mixSeed(seed, lattice(0), lattice(1), lattice(2));
    double weight = 1.0;
    for (int axis = 0; axis < 3; ++axis) weight *= bit[axis] ? blend[axis] : 1.0 - blend[axis];
    sum += weight * (static_cast<double>(hash >> 40) * 0x1p-23 - 1.0);
  }
  return sum;
}

// octave_count layers, each of twice the frequency and half the height; in (-2, 2), mostly within [-1, 1].
inline double fractalNoise(uint64_t seed, const glm::dvec3& p, int octave_count) {
  double sum = 0.0;
  double height = 1.0;
  glm::dvec3 q = p;
  for (int octave = 0; octave < octave_count; ++octave, height *= 0.5, q *= 2.0) {
    sum += height * valueNoise(mixSeed(seed, static_cast<uint64_t>(octave)), q);
  }
  return sum;
}

}  // namespace nlg
