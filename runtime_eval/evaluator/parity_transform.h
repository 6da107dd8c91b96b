// The Walsh–Hadamard transform over the 8 mirror images, which splits a weighting function into parity classes.
//
// class(c, i) = Σ_m (-1)^popcount(c & m) 255 phi(m, i), unscaled. For stored functions these are whole numbers: class 0 from 0 to
// 2040, the others from -1020 to 1020, since half of their signs are negative. docs/theory/math.md §2.
#pragma once

#include <cstdint>

#include "nlg/support.h"

namespace nlg {

inline constexpr int kParityClassCount = 8;

// Numbers from one function's classes to the next one's: P, and a cache line more. With a power of two the rows of a product's
// tile would all fall into one set of the first-level cache.
inline constexpr int kClassStride = kSupportPointCount + 64;

// Classes of `count` functions.
// phi      count x P in pattern order; bytes: round(255 phi); floats: phi in [0, 1]
// classes  function n begins at n * kClassStride, class c of it c * 1024 further
void parityTransform(const uint8_t* phi, int count, float* classes);
void parityTransform(const float* phi, int count, float* classes);

// +1 or -1: what mirroring a function by `mirror` does to its coefficients of parity class `parity_class`.
inline float mirrorSign(int parity_class, int mirror) { return __builtin_popcount(parity_class & mirror) & 1 ? -1.0f : 1.0f; }

}  // namespace nlg
