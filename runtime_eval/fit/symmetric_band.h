// A symmetric matrix that is zero far from its diagonal, and the solution of systems with it: the linear algebra of
// Levenberg–Marquardt. A full matrix is one whose band is as wide as itself.
#pragma once

#include <cstddef>
#include <vector>

namespace nlg {

class SymmetricBand {
 public:
  SymmetricBand() = default;
  // All zero. bandwidth   largest |row - column| of an entry that may differ from zero; 0 <= bandwidth < count
  SymmetricBand(int count, int bandwidth);

  int count() const { return count_; }
  int bandwidth() const { return bandwidth_; }
  // Entry (row, column) of the lower triangle: row - bandwidth <= column <= row.
  double& at(int row, int column) { return rows_[static_cast<size_t>(row) * (bandwidth_ + 1) + (column - row + bandwidth_)]; }
  double at(int row, int column) const {
    return rows_[static_cast<size_t>(row) * (bandwidth_ + 1) + (column - row + bandwidth_)];
  }
  // Entries (row, row - bandwidth … row), one row after another; those left of column 0 are not used.
  double* data() { return rows_.data(); }

  void setZero();
  // result = matrix * vector, count each.
  void multiply(const double* vector, double* result) const;
  // Solves matrix * x = vector by Cholesky in place: the matrix is destroyed, the vector becomes x. False when a pivot is not
  // positive or not finite.
  bool solve(double* vector);

 private:
  int count_ = 0, bandwidth_ = 0;
  std::vector<double> rows_;
};

}  // namespace nlg
