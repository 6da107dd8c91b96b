// Inner products of all pairs of rows, for any Highway target, from which normal equations are built. Included once per
// target; see Highway's quick reference on "-inl.h".
#if defined(NLG_GRAM_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef NLG_GRAM_INL_H_
#undef NLG_GRAM_INL_H_
#else
#define NLG_GRAM_INL_H_
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kGramTile = 4;  // 16 sums and 8 rows at a time: they fit the 32 registers of AVX-512, nearly the 16 of the others

// Adds sum over i < count of rows(r, i) * columns(c, i) to sums(r, c), r, c < kGramTile.
// row_stride   floats from one row to the next; count is a multiple of the vector's lanes
HWY_INLINE void addTileProducts(const float* HWY_RESTRICT rows, const float* HWY_RESTRICT columns, int row_stride, int count,
                                double* HWY_RESTRICT sums, int sum_stride) {
  const hn::CappedTag<float, 16> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  hn::Vec<decltype(d)> accumulator[kGramTile][kGramTile];
#pragma GCC unroll 4
  for (int r = 0; r < kGramTile; ++r) {
#pragma GCC unroll 4
    for (int c = 0; c < kGramTile; ++c) accumulator[r][c] = hn::Zero(d);
  }
  for (int i = 0; i < count; i += lanes) {
    hn::Vec<decltype(d)> column[kGramTile];
#pragma GCC unroll 4
    for (int c = 0; c < kGramTile; ++c) column[c] = hn::Load(d, columns + c * row_stride + i);
#pragma GCC unroll 4
    for (int r = 0; r < kGramTile; ++r) {
      const auto row = hn::Load(d, rows + r * row_stride + i);
#pragma GCC unroll 4
      for (int c = 0; c < kGramTile; ++c) accumulator[r][c] = hn::MulAdd(row, column[c], accumulator[r][c]);
    }
  }
#pragma GCC unroll 4
  for (int r = 0; r < kGramTile; ++r) {
#pragma GCC unroll 4
    for (int c = 0; c < kGramTile; ++c) sums[r * sum_stride + c] += hn::GetLane(hn::SumOfLanes(d, accumulator[r][c]));
  }
}

// Adds the products of all pairs of `row_count` rows (a multiple of kGramTile) to the lower triangle of tiles of `sums`,
// row_count² numbers.
HWY_INLINE void addGram(const float* HWY_RESTRICT rows, int row_count, int row_stride, int count, double* HWY_RESTRICT sums) {
  for (int r = 0; r < row_count; r += kGramTile) {
    for (int c = 0; c <= r; c += kGramTile) {
      addTileProducts(rows + r * row_stride, rows + c * row_stride, row_stride, count, sums + r * row_count + c, row_count);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();
#endif
