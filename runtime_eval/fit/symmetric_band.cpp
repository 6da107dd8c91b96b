#include "runtime_eval/fit/symmetric_band.h"

#include <algorithm>
#include <cmath>

namespace nlg {

SymmetricBand::SymmetricBand(int count, int bandwidth)
    : count_(count), bandwidth_(bandwidth), rows_(static_cast<size_t>(count) * (bandwidth + 1), 0.0) {}

void SymmetricBand::setZero() { std::fill(rows_.begin(), rows_.end(), 0.0); }

void SymmetricBand::multiply(const double* vector, double* result) const {
  std::fill_n(result, count_, 0.0);
  for (int i = 0; i < count_; ++i) {
    for (int j = std::max(0, i - bandwidth_); j < i; ++j) {
      result[i] += at(i, j) * vector[j];
      result[j] += at(i, j) * vector[i];
    }
    result[i] += at(i, i) * vector[i];
  }
}

bool SymmetricBand::solve(double* vector) {
  for (int i = 0; i < count_; ++i) {
    const int first = std::max(0, i - bandwidth_);
    for (int j = first; j <= i; ++j) {
      double sum = at(i, j);
      for (int k = std::max(first, j - bandwidth_); k < j; ++k) sum -= at(i, k) * at(j, k);
      if (j < i) {
        at(i, j) = sum / at(j, j);
      } else {
        if (!(sum > 0.0) || !std::isfinite(sum)) return false;
        at(i, i) = std::sqrt(sum);
      }
    }
  }
  for (int i = 0; i < count_; ++i) {
    for (int k = std::max(0, i - bandwidth_); k < i; ++k) vector[i] -= at(i, k) * vector[k];
    vector[i] /= at(i, i);
  }
  for (int i = count_ - 1; i >= 0; --i) {
    vector[i] /= at(i, i);
    for (int k = std::max(0, i - bandwidth_); k < i; ++k) vector[k] -= at(i, k) * vector[i];
  }
  return true;
}

}  // namespace nlg
