// The generator's input: coefficients of a weighting function.
//
// Components are block-diagonal over the 8 parity classes (docs/theory/math.md §3): class c of a function is the signed sum of its 8
// mirror images, sign (-1)^popcount(c & m), divided by sqrt(8). A component lives in one class. It weighs phi at all support points, or
// three channels at the sample points.
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
// phi      count x P in pattern order, round(255 phi)
// classes  function n begins at n * kClassStride, class c of it c * 1024 further
void parityTransform(const uint8_t* phi, int count, float* classes);

// +1 or -1: what mirroring a function by `mirror` does to its coefficients of parity class `parity_class`.
inline float mirrorSign(int parity_class, int mirror) { return __builtin_popcount(parity_class & mirror) & 1 ? -1.0f : 1.0f; }

// What components weigh.
enum class GeneratorInput : uint8_t {
  coefficients,  // phi at all support points: principal components
  samples,       // phi, visibility and validity at the sample points: components that are trained with the generator
};

// Of samples. A dark point and one in solid are alike in phi; the generator tells them by their validity.
inline constexpr int kSampleChannelCount = 3;

// Numbers of one function in one parity class.
constexpr int inputCount(GeneratorInput input) {
  return input == GeneratorInput::samples ? kSampleChannelCount * kOctantSampleCount : kOctantPointCount;
}
inline constexpr int kSampleInputCount = kParityClassCount * inputCount(GeneratorInput::samples);

// The rim of a support would make large numbers of the rounding of phi: no smaller tent divides it.
inline constexpr float kLeastTent = 1e-3f;

// Parity classes of phi, .3 (V - .7) m and .3 (m - .9) at the sample points, divided by sqrt(8): V = min(1, phi / tent), m is 1 where the
// point is valid. The offsets are about the means, the factors make the channels alike in size.
// classes   kSampleInputCount: class c begins at c * 384, channel k of it k * 128 further
void sampleClasses(const StoredFunction& function, float* classes);
void sampleClasses(const VisibilitySamples& function, float* classes);
// As of the VisibilitySamples that a whole function has; it must have `seen`.
void visibilityClasses(const StoredFunction& function, float* classes);

// The numbers of a basis as its file holds them.
struct BasisData {
  GeneratorInput input = GeneratorInput::coefficients;
  std::array<int, kParityClassCount> class_count{};  // components in each class; their sum is K
  std::vector<float> mean;                           // 8 x 1024: parity classes of the mean function; of samples empty, it is 0
  std::vector<float> components;                     // K x inputCount(input), grouped by class; of coefficients orthonormal rows
  // K, > 0: what each coefficient is divided by. From nlg-pca its standard deviation over the training set; training may choose
  // something between that and one number for all (whitened(), train/basis/basis_fit.h). Of samples 1
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
  GeneratorInput input() const { return input_; }

  // Coefficients of functions, mean 0 over the training set, divided as the basis says.
  // count         0 <= count <= kBatchCount
  // coefficients  count x K
  void project(const StoredFunction* functions, int count, float* coefficients, ProjectionScratch* scratch) const;
  // Of a basis of samples.
  void project(const VisibilitySamples* functions, int count, float* coefficients, ProjectionScratch* scratch) const;

 private:
  template <class Function>
  void projectSamples(const Function* functions, int count, float* coefficients, ProjectionScratch* scratch) const;
  void multiplyClasses(int count, float* coefficients, const ProjectionScratch& scratch) const;

  GeneratorInput input_ = GeneratorInput::coefficients;
  int coefficient_count_ = 0;
  std::array<PackedMatrix, kParityClassCount> components_;  // dequantisation, 1/sqrt(8) and standardisation folded in
  AlignedFloats bias_;                                      // minus the mean's coefficients
};

}  // namespace nlg
