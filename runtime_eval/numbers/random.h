// Random numbers that are the same on every machine: PCG32 (O'Neill 2014, pcg-random.org), and exact draws from it.
#pragma once

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <numbers>

namespace nlg {

// Mixes any number of integers into one seed (SplitMix64's finaliser): streams for (scene, jitter, stage) that do not overlap.
inline uint64_t mixSeed(uint64_t a, uint64_t b = 0, uint64_t c = 0, uint64_t d = 0) {
  uint64_t hash = 0x9e3779b97f4a7c15u;
  for (const uint64_t value : {a, b, c, d}) {
    hash += value + 0x9e3779b97f4a7c15u;
    hash = (hash ^ (hash >> 30)) * 0xbf58476d1ce4e5b9u;
    hash = (hash ^ (hash >> 27)) * 0x94d049bb133111ebu;
    hash ^= hash >> 31;
  }
  return hash;
}

class Random {
 public:
  explicit Random(uint64_t seed) : state_(0), increment_(mixSeed(seed, 1) | 1) {
    next();
    state_ += mixSeed(seed, 2);
    next();
  }

  uint32_t next() {
    const uint64_t old = state_;
    state_ = old * 6364136223846793005u + increment_;
    const uint32_t shifted = static_cast<uint32_t>(((old >> 18) ^ old) >> 27);
    const uint32_t turn = static_cast<uint32_t>(old >> 59);
    return (shifted >> turn) | (shifted << ((32 - turn) & 31));
  }

  // Uniform integer in [0, count), count >= 1; the bias is below count / 2^32.
  uint32_t below(uint32_t count) { return static_cast<uint32_t>((uint64_t{next()} * count) >> 32); }
  // Uniform in [0, 1), a multiple of 2^-24: exact in float and double.
  double uniform() { return (next() >> 8) * 0x1p-24; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  bool chance(double probability) { return uniform() < probability; }
  // Standard normal (Box–Muller).
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }

 private:
  uint64_t state_, increment_;
};

}  // namespace nlg
