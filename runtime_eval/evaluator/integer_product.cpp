#include "runtime_eval/evaluator/integer_product.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#define HWY_WANT_AVX3_DL
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/evaluator/integer_product.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using SumTag = hn::CappedTag<int32_t, 16>;
using FloatTag = hn::Rebind<float, SumTag>;
using Sums = hn::Vec<SumTag>;

constexpr int kPanelWidth = PackedIntegerMatrix::kPanelWidth;
constexpr int kLanes = HWY_LANES(int32_t) < 16 ? HWY_LANES(int32_t) : 16;
// sums in registers: 12 x 2 of the 32 registers of AVX-512, 6 x 2 of the 16 of the others
constexpr int kTileVectors = 2;
constexpr int kTileRows = kLanes == 16 ? 12 : 6;
constexpr int kTileColumns = kTileVectors * kLanes;
// A block of a panel (16 KiB), its rows' inputs and their sums stay in the first-level cache while the rows pass.
constexpr int kBlockPairs = 128;
constexpr int kBlockRows = 96;

// Two products into each 32-bit sum. Where the instruction does not pair neighbours (NEON) a second sum takes the other half.
#if HWY_TARGET == HWY_AVX3_DL
// Highway 1.0 leaves this instruction out, though it checks that the machine has it
HWY_INLINE Sums addPairs(int32_t pair, const int16_t* HWY_RESTRICT column, Sums sum, Sums&) {
  const hn::Repartition<int16_t, SumTag> d16;
  asm("vpdpwssd %2, %1, %0" : "+v"(sum.raw) : "v"(hn::Set(SumTag(), pair).raw), "v"(hn::Load(d16, column).raw));
  return sum;
}
HWY_INLINE Sums wholeSum(Sums sum, Sums) { return sum; }
#elif HWY_ARCH_X86 && HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128
HWY_INLINE Sums addPairs(int32_t pair, const int16_t* HWY_RESTRICT column, Sums sum, Sums& other) {
  const SumTag d;
  const hn::Repartition<int16_t, SumTag> d16;
  sum = hn::ReorderWidenMulAccumulate(d, hn::BitCast(d16, hn::Set(d, pair)), hn::Load(d16, column), sum, other);
  // in this order: the compiler would compute all products of the tile first and spill half of them
  asm volatile("" : "+v"(sum.raw));
  return sum;
}
HWY_INLINE Sums wholeSum(Sums sum, Sums) { return sum; }
#elif HWY_TARGET != HWY_SCALAR
HWY_INLINE Sums addPairs(int32_t pair, const int16_t* HWY_RESTRICT column, Sums sum, Sums& other) {
  const SumTag d;
  const hn::Repartition<int16_t, SumTag> d16;
  return hn::ReorderWidenMulAccumulate(d, hn::BitCast(d16, hn::Set(d, pair)), hn::Load(d16, column), sum, other);
}
HWY_INLINE Sums wholeSum(Sums sum, Sums other) { return hn::RearrangeToOddPlusEven(sum, other); }
#else
HWY_INLINE Sums addPairs(int32_t pair, const int16_t* HWY_RESTRICT column, Sums sum, Sums&) {
  int16_t value[2];
  std::memcpy(value, &pair, sizeof pair);
  return hn::Add(sum, hn::Set(SumTag(), value[0] * column[0] + value[1] * column[1]));
}
HWY_INLINE Sums wholeSum(Sums sum, Sums) { return sum; }
#endif

// sums: kRows x kTileColumns, dense; added to
template <int kRows, int kVectors>
HWY_INLINE void sumTile(const int16_t* HWY_RESTRICT input, int stride, const int16_t* HWY_RESTRICT panel, int pair_count,
                        int32_t* HWY_RESTRICT sums) {
  const SumTag d;
  Sums sum[kRows][kVectors], other[kRows][kVectors];
#pragma GCC unroll 12
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 2
    for (int v = 0; v < kVectors; ++v) {
      sum[r][v] = hn::Zero(d);
      other[r][v] = hn::Zero(d);
    }
  }
  for (int p = 0; p < pair_count; ++p, panel += 2 * kPanelWidth) {
#pragma GCC unroll 12
    for (int r = 0; r < kRows; ++r) {
      int32_t pair;
      std::memcpy(&pair, input + r * stride + 2 * p, sizeof pair);
#pragma GCC unroll 2
      for (int v = 0; v < kVectors; ++v) sum[r][v] = addPairs(pair, panel + 2 * v * kLanes, sum[r][v], other[r][v]);
    }
  }
#pragma GCC unroll 12
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 2
    for (int v = 0; v < kVectors; ++v) {
      int32_t* to = sums + r * kTileColumns + v * kLanes;
      hn::Store(hn::Add(hn::Load(d, to), wholeSum(sum[r][v], other[r][v])), d, to);
    }
  }
}

// One strip of outputs, padded to whole vectors.
struct Strip {
  int columns;  // of kTileColumns, how many there are
  alignas(64) float step[kTileColumns], bias[kTileColumns];
  Epilogue epilogue;
  float slope;
};

void finishRow(const Strip& strip, const int32_t* HWY_RESTRICT sums, float scale, const float* HWY_RESTRICT skip,
               float* HWY_RESTRICT output) {
  const SumTag d;
  const FloatTag df;
  const bool whole = strip.columns == kTileColumns;
  alignas(64) float buffer[kTileColumns], skip_buffer[kTileColumns] = {};
  const bool skips = strip.epilogue == Epilogue::leaky_and_skip;
  if (skips && !whole) {
    std::copy_n(skip, strip.columns, skip_buffer);
    skip = skip_buffer;
  }
  float* line = whole ? output : buffer;
  for (int v = 0; v < kTileColumns; v += kLanes) {
    auto value = hn::Mul(hn::ConvertTo(df, hn::LoadU(d, sums + v)), hn::Load(df, strip.step + v));
    value = hn::Add(hn::Mul(value, hn::Set(df, scale)), hn::Load(df, strip.bias + v));
    if (strip.epilogue != Epilogue::none) value = hn::Max(value, hn::Mul(hn::Set(df, strip.slope), value));
    if (skips) value = hn::Add(value, hn::LoadU(df, skip + v));
    hn::StoreU(value, df, line + v);
  }
  if (!whole) std::copy_n(buffer, strip.columns, output);
}

// The rows from `row` on by tiles of kRows, what is left by smaller ones.
template <int kRows, int kVectors>
void sumRows(const int16_t* input, int stride, int row, int row_count, const int16_t* panel, int pair_count, int32_t* sums) {
  for (; row + kRows <= row_count; row += kRows) {
    sumTile<kRows, kVectors>(input + row * stride, stride, panel, pair_count, sums + row * kTileColumns);
  }
  if constexpr (kRows > 1) sumRows<kRows / 2, kVectors>(input, stride, row, row_count, panel, pair_count, sums);
}

void multiplyAll(IntegerRows input, int row_count, const PackedIntegerMatrix& matrix, const float* bias, Epilogue epilogue,
                 float slope, const float* skip, float* output, int output_stride) {
  alignas(64) int32_t sums[kBlockRows * kTileColumns];
  const int width = matrix.outputCount();
  for (int begin = 0; begin < row_count; begin += kBlockRows) {
    const int rows = std::min(kBlockRows, row_count - begin);
    const int16_t* values = input.values + size_t(begin) * input.stride;
    for (int first = 0; first < width; first += kTileColumns) {
      Strip strip{};
      strip.columns = std::min(kTileColumns, width - first);
      std::copy_n(matrix.steps() + first, strip.columns, strip.step);
      std::copy_n(bias + first, strip.columns, strip.bias);
      strip.epilogue = epilogue;
      strip.slope = slope;
      const int16_t* panel = matrix.panel(first / kPanelWidth) + 2 * (first % kPanelWidth);
      std::fill_n(sums, rows * kTileColumns, 0);
      for (int pair = 0; pair < matrix.pairCount(); pair += kBlockPairs) {
        const int pairs = std::min(kBlockPairs, matrix.pairCount() - pair);
        const int16_t* block = panel + size_t(pair) * 2 * kPanelWidth;
        // a class of the basis often ends in a few outputs: half a tile costs half
        if (strip.columns <= kTileColumns / 2) {
          sumRows<kTileRows, kTileVectors / 2>(values + 2 * pair, input.stride, 0, rows, block, pairs, sums);
        } else {
          sumRows<kTileRows, kTileVectors>(values + 2 * pair, input.stride, 0, rows, block, pairs, sums);
        }
      }
      for (int r = 0; r < rows; ++r) {
        const size_t n = size_t(begin) + r;
        finishRow(strip, sums + r * kTileColumns, input.scales ? input.scales[n] : 1.0f,
                  epilogue == Epilogue::leaky_and_skip ? skip + n * width + first : nullptr, output + n * output_stride + first);
      }
    }
  }
}

void quantiseRow(const float* HWY_RESTRICT row, int count, int16_t* HWY_RESTRICT integers, float* HWY_RESTRICT scale) {
  const FloatTag df;
  const hn::Rebind<int16_t, FloatTag> d16;
  auto largest = hn::Zero(df);
  int i = 0;
  for (; i + kLanes <= count; i += kLanes) largest = hn::Max(largest, hn::Abs(hn::LoadU(df, row + i)));
  float limit = hn::GetLane(hn::MaxOfLanes(df, largest));
  for (; i < count; ++i) limit = std::max(limit, std::fabs(row[i]));
  *scale = limit / kActivationLimit;
  // smaller than any activation that matters, and with an inverse that is finite
  const float inverse = limit < 1e-30f ? 0.0f : kActivationLimit / limit;
  for (i = 0; i + kLanes <= count; i += kLanes) {
    const auto scaled = hn::Mul(hn::LoadU(df, row + i), hn::Set(df, inverse));
    hn::StoreU(hn::DemoteTo(d16, hn::NearestInt(scaled)), d16, integers + i);
  }
  for (; i < count; ++i) integers[i] = hn::GetLane(hn::DemoteTo(d16, hn::NearestInt(hn::Set(df, row[i] * inverse))));
  if (count % 2 != 0) integers[count] = 0;
}

void quantiseAll(const float* rows, int row_count, int count, int16_t* integers, int stride, float* scales) {
  for (int n = 0; n < row_count; ++n) quantiseRow(rows + size_t(n) * count, count, integers + size_t(n) * stride, scales + n);
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(multiplyAll);
HWY_EXPORT(quantiseAll);

PackedIntegerMatrix::PackedIntegerMatrix(const float* rows, int output_count, int input_count, int input_limit)
    : input_count_(input_count), output_count_(output_count) {
  const int panel_count = (output_count + kPanelWidth - 1) / kPanelWidth;
  panels_.assign(size_t(panel_count) * pairCount() * 2 * kPanelWidth, 0);
  steps_.assign(size_t(panel_count) * kPanelWidth, 0.0f);
  // no sum leaves 32 bits when the magnitudes of an output's integers add up to at most this
  const double budget = std::floor(static_cast<double>(std::numeric_limits<int32_t>::max()) / input_limit);
  for (int o = 0; o < output_count; ++o) {
    const float* row = rows + size_t(o) * input_count;
    double total = 0.0, largest = 0.0;
    for (int i = 0; i < input_count; ++i) {
      total += std::fabs(static_cast<double>(row[i]));
      largest = std::max(largest, std::fabs(static_cast<double>(row[i])));
    }
    if (total == 0.0) continue;
    // rounding adds at most half a unit an input
    const double scale = std::min((budget - 0.5 * input_count) / total, 32767.0 / largest);
    steps_[o] = static_cast<float>(1.0 / scale);
    int16_t* column = &panels_[size_t(o / kPanelWidth) * pairCount() * 2 * kPanelWidth + 2 * (o % kPanelWidth)];
    for (int i = 0; i < input_count; ++i) {
      column[size_t(i / 2) * 2 * kPanelWidth + i % 2] = static_cast<int16_t>(std::lround(row[i] * scale));
    }
  }
}

int PackedIntegerMatrix::weightSum(int output) const {
  const int16_t* column = panel(output / kPanelWidth) + 2 * (output % kPanelWidth);
  int sum = 0;
  for (int i = 0; i < input_count_; ++i) sum += column[size_t(i / 2) * 2 * kPanelWidth + i % 2];
  return sum;
}

void quantiseRows(const float* rows, int row_count, int count, int16_t* integers, int stride, float* scales) {
  HWY_DYNAMIC_DISPATCH(quantiseAll)(rows, row_count, count, integers, stride, scales);
}

void multiply(IntegerRows input, int row_count, const PackedIntegerMatrix& matrix, const float* bias, Epilogue epilogue,
              float slope, const float* skip, float* output, int output_stride) {
  HWY_DYNAMIC_DISPATCH(multiplyAll)(input, row_count, matrix, bias, epilogue, slope, skip, output, output_stride);
}

}  // namespace nlg
#endif  // HWY_ONCE
