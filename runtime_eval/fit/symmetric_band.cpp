// Blocked Cholesky: a panel of eight rows of U at a time is taken out of the rows below it, in tiles that stay in registers.
// About half of D b² multiply-adds for bandwidth b, where a full matrix takes a sixth of D³ (docs/theory/representations.md §8).
#include "runtime_eval/fit/symmetric_band.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/fit/symmetric_band.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include <hwy/highway.h>

#ifndef NLG_SYMMETRIC_BAND_LAYOUT
#define NLG_SYMMETRIC_BAND_LAYOUT
namespace nlg {
// Rows of U are eliminated so many at a time, a panel; no vector is longer.
inline constexpr int kPanel = 8;

// A = U^T U, U in the place of the upper triangle, row i at entries + i * stride, column j of it at [j]. What vectors touch
// beside columns i … i + bandwidth of row i belongs to no other row:
//     i - 7 … i - 1                                 a tile's corner below the diagonal: any number, never used
//     i + bandwidth + 1 … i + bandwidth + 14        the rest of a panel's columns, up to a whole vector: always 0
// Rows count … padded_count - 1 have 1 on the diagonal, so that every panel is whole.
struct Band {
  int padded_count, bandwidth, stride;
  double* entries;
  double* row(int i) const { return entries + static_cast<size_t>(i) * stride; }
};
}  // namespace nlg
#endif

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using DoubleTag = hn::CappedTag<double, kPanel>;
using Doubles = hn::Vec<DoubleTag>;

// Factors the panel's own triangle; inverses of the diagonal in `inverse`. False on a pivot not positive or not finite.
HWY_INLINE bool factorTriangle(const Band& band, int first, double* inverse) {
  for (int p = 0; p < kPanel; ++p) {
    double* row = band.row(first + p) + first;
    const double pivot = row[p];
    if (!(pivot > 0.0) || !std::isfinite(pivot)) return false;
    const double root = std::sqrt(pivot);
    row[p] = root;
    inverse[p] = 1.0 / root;
    for (int j = p + 1; j < kPanel; ++j) row[j] *= inverse[p];
    for (int q = p + 1; q < kPanel; ++q) {
      double* below = band.row(first + q) + first;
      for (int j = q; j < kPanel; ++j) below[j] -= row[q] * row[j];
    }
  }
  return true;
}

// The panel's rows right of its triangle, columns [begin, end): U = (U of the triangle)^-T A.
HWY_INLINE void solvePanel(const Band& band, int first, const double* inverse, int begin, int end) {
  const DoubleTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int j = begin; j < end; j += lanes) {
    Doubles column[kPanel];
#pragma GCC unroll 8
    for (int p = 0; p < kPanel; ++p) column[p] = hn::Load(d, band.row(first + p) + j);
#pragma GCC unroll 8
    for (int p = 0; p < kPanel; ++p) {
      column[p] = hn::Mul(column[p], hn::Set(d, inverse[p]));
      hn::Store(column[p], d, band.row(first + p) + j);
#pragma GCC unroll 8
      for (int q = p + 1; q < kPanel; ++q) {
        column[q] = hn::NegMulAdd(hn::Set(d, band.row(first + p)[first + q]), column[p], column[q]);
      }
    }
  }
}

// Takes the panel's share out of rows [row, row + 4), kVectors vectors from column j on.
template <int kVectors>
HWY_INLINE void updateTile(const Band& band, int first, int row, int j) {
  const DoubleTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  constexpr int kRows = 4;
  // the tile stays in registers while the panel's eight rows are taken out of it
  Doubles tile[kRows][kVectors];
#pragma GCC unroll 4
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) tile[r][v] = hn::Load(d, band.row(row + r) + j + v * lanes);
  }
#pragma GCC unroll 8
  for (int p = 0; p < kPanel; ++p) {
    const double* panel = band.row(first + p);
    Doubles column[kVectors];
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) column[v] = hn::Load(d, panel + j + v * lanes);
#pragma GCC unroll 4
    for (int r = 0; r < kRows; ++r) {
      const Doubles factor = hn::Set(d, panel[row + r]);
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) tile[r][v] = hn::NegMulAdd(factor, column[v], tile[r][v]);
    }
  }
#pragma GCC unroll 4
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) hn::Store(tile[r][v], d, band.row(row + r) + j + v * lanes);
  }
}

bool factorBand(const Band& band) {
  const int lanes = static_cast<int>(hn::Lanes(DoubleTag()));
  for (int first = 0; first < band.padded_count; first += kPanel) {
    double inverse[kPanel];
    if (!factorTriangle(band, first, inverse)) return false;
    // a row reaches `bandwidth` columns: further rows do not see this panel
    const int begin = first + kPanel;
    const int end = std::min(band.padded_count, (begin + band.bandwidth + kPanel - 1) / kPanel * kPanel);
    solvePanel(band, first, inverse, begin, end);
    for (int row = begin; row < end; row += 4) {
      // whole vectors from the tile's first column: what lies left of the diagonal is never used
      int j = row / kPanel * kPanel;
      for (; j + 3 * lanes <= end; j += 3 * lanes) updateTile<3>(band, first, row, j);
      if (j + 2 * lanes <= end) updateTile<2>(band, first, row, j), j += 2 * lanes;
      if (j < end) updateTile<1>(band, first, row, j);
    }
  }
  return true;
}

// Sum over i < count of row[i] * x[i]; and, with kAdd, result[i] += row[i] * factor.
template <bool kAdd>
HWY_INLINE double dot(const double* HWY_RESTRICT row, const double* HWY_RESTRICT x, int count, double factor,
                      double* HWY_RESTRICT result) {
  const DoubleTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Doubles factors = hn::Set(d, factor);
  // two sums in turn, because each multiply-add waits for the one before
  Doubles even = hn::Zero(d), odd = hn::Zero(d);
  int i = 0;
  const auto step = [&](int at, Doubles& sum) {
    const Doubles values = hn::LoadU(d, row + at);
    sum = hn::MulAdd(values, hn::LoadU(d, x + at), sum);
    if (kAdd) hn::StoreU(hn::MulAdd(values, factors, hn::LoadU(d, result + at)), d, result + at);
  };
  for (; i + 2 * lanes <= count; i += 2 * lanes) step(i, even), step(i + lanes, odd);
  if (i + lanes <= count) step(i, even), i += lanes;
  double sum = hn::GetLane(hn::SumOfLanes(d, hn::Add(even, odd)));
  for (; i < count; ++i) {
    sum += row[i] * x[i];
    if (kAdd) result[i] += row[i] * factor;
  }
  return sum;
}

// x[i] -= row[i] * factor
HWY_INLINE void subtract(const double* HWY_RESTRICT row, double factor, int count, double* HWY_RESTRICT x) {
  const DoubleTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Doubles factors = hn::Set(d, factor);
  int i = 0;
  for (; i + lanes <= count; i += lanes) hn::StoreU(hn::NegMulAdd(hn::LoadU(d, row + i), factors, hn::LoadU(d, x + i)), d, x + i);
  for (; i < count; ++i) x[i] -= row[i] * factor;
}

bool solveBand(const Band& band, int count, double* HWY_RESTRICT x) {
  if (!factorBand(band)) return false;
  // U^T y = b downward, then U x = y upward
  for (int i = 0; i < count; ++i) {
    x[i] /= band.row(i)[i];
    subtract(band.row(i) + i + 1, x[i], std::min(band.bandwidth, count - 1 - i), x + i + 1);
  }
  for (int i = count - 1; i >= 0; --i) {
    const int length = std::min(band.bandwidth, count - 1 - i);
    x[i] = (x[i] - dot<false>(band.row(i) + i + 1, x + i + 1, length, 0.0, nullptr)) / band.row(i)[i];
  }
  return true;
}

void multiplyBand(const Band& band, int count, const double* HWY_RESTRICT x, double* HWY_RESTRICT result) {
  std::fill_n(result, count, 0.0);
  for (int i = 0; i < count; ++i) {
    const int length = std::min(band.bandwidth, count - 1 - i);
    result[i] += band.row(i)[i] * x[i] + dot<true>(band.row(i) + i + 1, x + i + 1, length, x[i], result + i + 1);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(solveBand);
HWY_EXPORT(multiplyBand);

namespace {
int paddedCount(int count) { return (count + kPanel - 1) / kPanel * kPanel; }
}  // namespace

void SymmetricBand::reset(int count, int bandwidth) {
  count_ = count;
  bandwidth_ = bandwidth;
  // 7 + 1 + bandwidth + 14 entries belong to a row; an odd number of cache lines spreads rows over all sets of a cache
  const int lines = (bandwidth + 22 + 7) / 8;
  stride_ = 8 * (lines | 1);
  entries_.assign(static_cast<size_t>(paddedCount(count)) * (stride_ + 1) + bandwidth + 16, 0.0);
}

bool SymmetricBand::operator==(const SymmetricBand& other) const {
  if (count_ != other.count_ || bandwidth_ != other.bandwidth_) return false;
  for (int column = 0; column < count_; ++column) {
    for (int row = column; row <= std::min(count_ - 1, column + bandwidth_); ++row) {
      if (at(row, column) != other.at(row, column)) return false;
    }
  }
  return true;
}

void SymmetricBand::multiply(const double* vector, double* result) const {
  // multiplyBand only reads
  const Band band{paddedCount(count_), bandwidth_, stride_, const_cast<double*>(entries_.data())};
  HWY_DYNAMIC_DISPATCH(multiplyBand)(band, count_, vector, result);
}

bool SymmetricBand::solve(double* vector) {
  const Band band{paddedCount(count_), bandwidth_, stride_, entries_.data()};
  for (int i = count_; i < band.padded_count; ++i) band.row(i)[i] = 1.0;
  return HWY_DYNAMIC_DISPATCH(solveBand)(band, count_, vector);
}

}  // namespace nlg
#endif  // HWY_ONCE
