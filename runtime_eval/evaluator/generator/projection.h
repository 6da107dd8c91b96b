// Projects weighting functions onto the PCA basis: the generator's input.
//
// The basis is block-diagonal over the 8 parity classes (docs/theory/math.md §3): class c of a function is the signed sum of its 8
// mirror images, sign (-1)^popcount(c & m), divided by sqrt(8). A component lives in one class and has 1024 numbers.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nlg/support.h"
#include "runtime_eval/evaluator/generator/matrix_product.h"

namespace nlg {

// The Walsh–Hadamard transform over the 8 mirror images, which splits a weighting function into parity classes.
//
// class(c, i) = Σ_m (-1)^popcount(c & m) 255 phi(m, i), unscaled. For stored functions these are whole numbers: class 0 from 0 to
// 2040, the others from -1020 to 1020, since half of their signs are negative. docs/theory/math.md §2.
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

// The numbers of a basis as its file holds them.
struct BasisData {
  std::array<int, kParityClassCount> class_count{};  // components in each class; their sum is K
  std::vector<float> mean;                           // 8 x 1024: parity classes of the mean function
  std::vector<float> components;                     // K x 1024, orthonormal rows, grouped by class
  // K, > 0: what each coefficient is divided by. From nlg-pca its standard deviation over the training set; training may choose
  // something between that and one number for all (whitened(), train/basis/basis_fit.h)
  std::vector<float> deviation;
  int coefficientCount() const { return static_cast<int>(deviation.size()); }
};

// The largest batch that one call projects; scratch is sized for it.
inline constexpr int kBatchCount = 96;

// Working memory of one thread.
class ProjectionScratch {
 public:
  ProjectionScratch() : classes_(size_t{kBatchCount} * kClassStride) {}

 private:
  friend class Projection;
  AlignedFloats classes_;
};

class Projection {
 public:
  Projection() = default;
  explicit Projection(const BasisData& basis);

  int coefficientCount() const { return coefficient_count_; }

  // Coefficients of functions, mean 0 over the training set, divided as the basis says.
  // phi           count x P in pattern order; bytes: round(255 phi); floats: phi in [0, 1]
  // count         0 <= count <= kBatchCount
  // coefficients  count x K
  void project(const uint8_t* phi, int count, float* coefficients, ProjectionScratch* scratch) const;
  void project(const float* phi, int count, float* coefficients, ProjectionScratch* scratch) const;

 private:
  template <class Sample>
  void projectSamples(const Sample* phi, int count, float* coefficients, ProjectionScratch* scratch) const;

  int coefficient_count_ = 0;
  std::array<PackedMatrix, kParityClassCount> components_;  // dequantisation, 1/sqrt(8) and standardisation folded in
  AlignedFloats bias_;                                      // minus the mean's coefficients
};

}  // namespace nlg
