// Projects weighting functions onto the PCA basis: the generator's input.
//
// The basis is block-diagonal over the 8 parity classes (docs/math.md §3): class c of a function is the signed sum of its 8
// mirror images, sign (-1)^popcount(c & m), divided by sqrt(8). A component lives in one class and has 1024 numbers.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "runtime_eval/evaluator/matrix_product.h"
#include "runtime_eval/support/support_pattern.h"

namespace nlg {

inline constexpr int kParityClassCount = 8;

// The numbers of a basis as its file holds them.
struct BasisData {
  std::array<int, kParityClassCount> class_count{};  // components in each class; their sum is K
  std::vector<float> mean;                           // 8 x 1024: parity classes of the mean function
  std::vector<float> components;                     // K x 1024, orthonormal rows, grouped by class
  std::vector<float> deviation;                      // K, standard deviation of each coefficient over the training set, > 0
  int coefficientCount() const { return static_cast<int>(deviation.size()); }
};

// The largest batch that one call projects; scratch is sized for it.
inline constexpr int kBatchCount = 96;

class Projection {
 public:
  Projection() = default;
  explicit Projection(const BasisData& basis);

  int coefficientCount() const { return coefficient_count_; }
  static constexpr int kScratchFloats = kBatchCount * kSupportPointCount;

  // Standardised coefficients (mean 0, deviation 1 over the training set) of stored functions.
  // phi           count x P, round(255 phi), pattern order
  // count         0 <= count <= kBatchCount
  // coefficients  count x K
  // scratch       kScratchFloats floats, 64-byte aligned
  void project(const uint8_t* phi, int count, float* coefficients, float* scratch) const;

 private:
  int coefficient_count_ = 0;
  std::array<PackedMatrix, kParityClassCount> components_;  // dequantisation, 1/sqrt(8) and standardisation folded in
  AlignedFloats bias_;                                      // minus the mean's coefficients
};

// Splits stored functions into parity classes, unscaled: classes(n, c, i) = Σ_m (-1)^popcount(c & m) phi(n, m, i).
// phi      count x P;  classes  count x 8 x 1024 floats
void parityTransform(const uint8_t* phi, int count, float* classes);

// +1 or -1: what mirroring a function by `mirror` does to its coefficients of parity class `parity_class`.
inline float mirrorSign(int parity_class, int mirror) { return __builtin_popcount(parity_class & mirror) & 1 ? -1.0f : 1.0f; }

}  // namespace nlg
