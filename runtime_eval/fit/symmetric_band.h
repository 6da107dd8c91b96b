// A symmetric band matrix and the solution of systems with it, for Levenberg–Marquardt. A full matrix is one whose band is as
// wide as itself.
#pragma once

#include <cstddef>
#include <vector>

#include "runtime_eval/simd/aligned.h"

namespace nlg {

class SymmetricBand {
 public:
  SymmetricBand() = default;
  // All zero. bandwidth   largest |row - column| of an entry that may differ from zero; 0 <= bandwidth < count
  SymmetricBand(int count, int bandwidth) { reset(count, bandwidth); }

  // All zero, of another shape; allocates only to grow.
  void reset(int count, int bandwidth);

  int count() const { return count_; }
  int bandwidth() const { return bandwidth_; }
  // Entry (row, column) of the lower triangle: row - bandwidth <= column <= row.
  double& at(int row, int column) { return entries_[static_cast<size_t>(column) * stride_ + row]; }
  double at(int row, int column) const { return entries_[static_cast<size_t>(column) * stride_ + row]; }

  // The same shape and, by ==, the same entries.
  bool operator==(const SymmetricBand& other) const;

  // result = matrix * vector, count each; they may not overlap.
  void multiply(const double* vector, double* result) const;
  // Solves matrix * x = vector by Cholesky in place: the matrix is destroyed, the vector becomes x. False when a pivot is not
  // positive or not finite; the vector is then as it was.
  bool solve(double* vector);

 private:
  // Column after column of the lower triangle, which is row after row of the upper one: entry (row, column) at column * stride +
  // row. Columns are so far apart that vectors may reach over both ends of what a column holds (symmetric_band.cpp).
  int count_ = 0, bandwidth_ = 0, stride_ = 0;
  std::vector<double, CacheLineAllocator<double>> entries_;
};

}  // namespace nlg
