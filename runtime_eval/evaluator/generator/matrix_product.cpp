#include "runtime_eval/evaluator/generator/matrix_product.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/evaluator/generator/matrix_product.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
// after foreach_target.h
#include "runtime_eval/evaluator/elementary-inl.h"

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {

// A tile's sums stay in registers: 12 rows x 2 vectors of the 32 registers of AVX-512, 3 x 4 of the 16 of the others.
constexpr int kLanes = HWY_LANES(float) < 16 ? HWY_LANES(float) : 16;
constexpr int kTileVectors = kLanes == 16 ? 2 : 4;
constexpr int kTileRows = kLanes == 16 ? 12 : 3;
constexpr int kTileColumns = kTileVectors * kLanes;

constexpr int kLineFloats = 16;

struct Tile {
  const float* HWY_RESTRICT input;
  int input_stride;
  const float* HWY_RESTRICT panel;
  int input_count;
  const float* ahead;  // cache lines to fetch meanwhile, one an input
  const float* HWY_RESTRICT bias;
  const float* HWY_RESTRICT skip;  // input at the tile's columns; null without skip
  bool leaky;
  float slope;
  float* HWY_RESTRICT output;
  int output_stride;
};

template <int kRows, int kVectors>
HWY_INLINE void multiplyTile(const Tile& tile) {
  const FloatTag d;
  Floats sum[kRows][kVectors];
#pragma GCC unroll 12
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) sum[r][v] = hn::LoadU(d, tile.bias + v * kLanes);
  }
  // inputs are summed in order, so that theta does not depend on its place in the batch, bit for bit (docs/guide/library.md)
  const float* HWY_RESTRICT panel = tile.panel;
  for (int k = 0; k < tile.input_count; ++k, panel += PackedMatrix::kPanelWidth) {
    Floats column[kVectors];
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) column[v] = hn::Load(d, panel + v * kLanes);
    hwy::Prefetch(tile.ahead + size_t(k) * kLineFloats);
#pragma GCC unroll 12
    for (int r = 0; r < kRows; ++r) {
      const Floats value = hn::Set(d, tile.input[r * tile.input_stride + k]);
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) sum[r][v] = hn::MulAdd(value, column[v], sum[r][v]);
    }
  }
  // LeakyReLU, then the skip, before the sums leave the registers
  const Floats slope = hn::Set(d, tile.slope);
#pragma GCC unroll 12
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) {
      Floats value = sum[r][v];
      if (tile.leaky) value = hn::Max(value, hn::Mul(slope, value));
      if (tile.skip) value = hn::Add(value, hn::LoadU(d, tile.skip + r * tile.input_stride + v * kLanes));
      hn::StoreU(value, d, tile.output + r * tile.output_stride + v * kLanes);
    }
  }
}

// The rows that are left over after whole tiles, by tiles of falling size.
template <int kRows, int kVectors>
void multiplyRows(Tile& tile, int& row, int row_count) {
  for (; row + kRows <= row_count; row += kRows) {
    multiplyTile<kRows, kVectors>(tile);
    tile.input += kRows * tile.input_stride;
    // the first two tiles fetch the panel that comes next; the others what is there already
    tile.ahead = row == 0 ? tile.ahead + size_t(tile.input_count) * kLineFloats : tile.panel;
    tile.output += kRows * tile.output_stride;
    if (tile.skip) tile.skip += kRows * tile.input_stride;
  }
  if constexpr (kRows > 1) multiplyRows<kRows / 2, kVectors>(tile, row, row_count);
}

// One strip of at most kTileColumns outputs. A strip that the outputs do not fill goes through a buffer.
void multiplyStrip(Tile tile, int row_count, int columns, Epilogue epilogue, const float* bias) {
  constexpr int kBufferRows = 96;
  alignas(64) float padded_bias[kTileColumns] = {};
  alignas(64) float buffer[kBufferRows * kTileColumns];
  alignas(64) float skip_buffer[kTileColumns];
  const bool whole = columns == kTileColumns;
  std::copy_n(bias, columns, padded_bias);
  tile.bias = padded_bias;
  tile.leaky = epilogue != Epilogue::none;
  if (whole) {
    int row = 0;
    multiplyRows<kTileRows, kTileVectors>(tile, row, row_count);
    return;
  }
  // a ragged strip computes whole vectors into a buffer: the output behind its columns belongs to others
  const float* skip = tile.skip;
  float* output = tile.output;
  const int output_stride = tile.output_stride;
  tile.skip = nullptr;
  for (int begin = 0; begin < row_count; begin += kBufferRows) {
    const int rows = std::min(kBufferRows, row_count - begin);
    Tile part = tile;
    part.input = tile.input + begin * tile.input_stride;
    part.output = buffer;
    part.output_stride = kTileColumns;
    int row = 0;
    // a class of the basis often ends in a few outputs: half a tile costs half
    if (columns <= kTileColumns / 2) {
      multiplyRows<kTileRows, kTileVectors / 2>(part, row, rows);
    } else {
      multiplyRows<kTileRows, kTileVectors>(part, row, rows);
    }
    // the skip is added here, because a tile would read it beyond the row
    for (int r = 0; r < rows; ++r) {
      std::fill_n(skip_buffer, columns, 0.0f);
      if (skip) std::copy_n(skip + (begin + r) * tile.input_stride, columns, skip_buffer);
      for (int c = 0; c < columns; ++c) output[(begin + r) * output_stride + c] = buffer[r * kTileColumns + c] + skip_buffer[c];
    }
  }
}

void multiplyAll(RowMatrix input, int row_count, const PackedMatrix& matrix, const float* bias, Epilogue epilogue, float slope,
                 float* output, int output_stride) {
  for (int first = 0; first < matrix.outputCount(); first += kTileColumns) {
    const int columns = std::min(kTileColumns, matrix.outputCount() - first);
    Tile tile{};
    tile.input = input.values;
    tile.input_stride = input.stride;
    tile.panel = matrix.panel(first / PackedMatrix::kPanelWidth) + first % PackedMatrix::kPanelWidth;
    tile.input_count = matrix.inputCount();
    const int next = std::min((first + kTileColumns) / PackedMatrix::kPanelWidth, matrix.panelCount() - 1);
    // few rows stream every panel once, which the hardware foresees by itself
    tile.ahead = row_count < kTileRows ? tile.panel : matrix.panel(next);
    tile.skip = epilogue == Epilogue::leaky_and_skip ? input.values + first : nullptr;
    tile.slope = slope;
    tile.output = output + first;
    tile.output_stride = output_stride;
    multiplyStrip(tile, row_count, columns, epilogue, bias + first);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(multiplyAll);

PackedMatrix::PackedMatrix(const float* rows, int output_count, int input_count)
    : input_count_(input_count), output_count_(output_count) {
  panels_.assign(size_t(panelCount()) * input_count * kPanelWidth, 0.0f);
  for (int o = 0; o < output_count; ++o) {
    float* column = &panels_[size_t(o / kPanelWidth) * input_count * kPanelWidth + o % kPanelWidth];
    for (int i = 0; i < input_count; ++i) column[size_t(i) * kPanelWidth] = rows[size_t(o) * input_count + i];
  }
}

void multiply(RowMatrix input, int row_count, const PackedMatrix& matrix, const float* bias, Epilogue epilogue, float slope,
              float* output, int output_stride) {
  HWY_DYNAMIC_DISPATCH(multiplyAll)(input, row_count, matrix, bias, epilogue, slope, output, output_stride);
}

}  // namespace nlg
#endif  // HWY_ONCE
