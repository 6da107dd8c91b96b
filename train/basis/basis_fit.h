// Fits the PCA basis: principal components of a set of weighting functions.
//
// Input of the generator: K coefficients stand for the P samples of one function. The basis is that of the training set *and all
// its mirror images*; over such a set the covariance falls into one block of 1024² for each of the 8 parity classes, exactly, so
// that eight small eigenproblems give the components (docs/theory/math.md §3).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "runtime_eval/evaluator/generator/projection.h"

namespace nlg {

struct Basis {
  BasisData data;                // the K components of largest variance, grouped by class, falling inside a class
  std::vector<double> spectrum;  // 8 x 1024: all eigenvalues by class, falling
  uint64_t function_count = 0;   // functions seen, mirror images not counted
};

// Accumulates first and second moments of functions, exactly, in double, in one pass: memory does not grow with their number.
class BasisFit {
 public:
  BasisFit();

  // phi   count x P, round(255 phi), pattern order
  void add(const uint8_t* phi, uint64_t count);

  // The basis of everything added so far. Components whose variance is below 1e-9 of the largest are left out, so K may be
  // smaller than asked for when the functions are few. The same additions give the same bytes on any number of threads.
  // component_count   1 <= K <= P
  // throws            InputError when no two different functions were added
  Basis fit(int component_count) const;

  uint64_t functionCount() const { return count_; }

 private:
  using ClassMatrix = std::vector<double>;  // 1024 x 1024, lower triangle
  uint64_t count_ = 0;
  std::vector<double> shift_;                            // 1024: subtracted from class 0, near its mean
  std::vector<double> sum_;                              // 1024: of shifted class 0; the other classes' means vanish
  std::array<ClassMatrix, kParityClassCount> products_;  // of shifted classes
};

// The same basis with only its component_count components of largest variance (all of them when it has fewer).
Basis truncateBasis(const Basis& basis, int component_count);

// The same basis with coefficients that are whitened less: each is divided by its deviation to the power of `whitening`, and all of
// them by one number that makes their mean square 1. 1: as they are, every deviation is 1; 0: deviations as the functions have them.
BasisData whitened(BasisData data, double whitening);

// Share of held-out variance that the first `count` components keep, for each count asked for (capped at K).
// Energy of every function minus the training mean, summed over functions.
std::vector<double> keptVariance(const Basis& basis, const uint8_t* phi, uint64_t function_count, const std::vector<int>& counts);

}  // namespace nlg
