// lookUpIrradiances: a block of positions at a time.
//
// Neighbours in the list that share a cell make a run; a run has 8 items, one a corner, and items are sorted by their function.
// So each theta is read once a block and runs on full vectors of positions, as far as the list has them. Then weights become
// shares for a vector of positions at once, and the 27 numbers of light are blended for one position after another, since 8
// probes are what neighbours need not share.
#include <algorithm>
#include <array>
#include <cstring>

#include "runtime_eval/evaluator/product_field.h"
#include "runtime_eval/light_grid/irradiance.h"
#include "runtime_eval/simd/aligned.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/light_grid/irradiance_batch.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include "runtime_eval/evaluator/tiny_network-inl.h"

#ifndef NLG_IRRADIANCE_BATCH_ONCE
#define NLG_IRRADIANCE_BATCH_ONCE
namespace nlg {

constexpr size_t kBlockSize = 16384;  // positions: as many as let scattered ones share functions
constexpr size_t kMaxRun = 128;       // positions of a run: with a group of lanes more, what the stage holds at least
constexpr size_t kStageSize = 512;    // positions of one function that are evaluated together
constexpr size_t kMaxLanes = 16;
constexpr size_t kPadded = kBlockSize + kMaxLanes;  // vectors may write past the last position

// Neighbours in the list in one cell.
struct CellRun {
  uint32_t first, count;  // positions of the block
  CellCorners corners;
};

// One corner of one run, by function: what is sorted.
struct RunItem {
  uint32_t function;
  uint32_t corner_of_run;  // 8 run + corner
};

struct LookUpScratch::Buffers {
  std::array<CellPlace, kBlockSize> places;
  alignas(64) float from_low[3][kPadded];
  alignas(64) float weight[8][kPadded];   // by corner; shares in the end
  alignas(64) float residue[8][kPadded];  // what weights lose
  alignas(64) float share_sum[kPadded];   // 0: no function has weight
  std::array<CellRun, kBlockSize> runs;
  std::array<RunItem, 8 * kBlockSize> items, sorted;
  size_t run_count, item_count;
  PointSet stage;  // local coordinates and tents of positions of one function
  alignas(64) float value[kStageSize + kMaxLanes];

  Buffers() {
    stage.padded_count = static_cast<int>(kStageSize + kMaxLanes);
    for (AlignedFloats* list : {&stage.x, &stage.y, &stage.z, &stage.tent}) list->assign(kStageSize + kMaxLanes, 0.0f);
  }
};

// The part of the list that one block is.
struct BatchSlice {
  const PositionM* positions_m;
  const float* normals_3;  // null: light is asked for
  size_t count;
  float* result;  // 3 floats a position, or kShFloats
  LightStatus* status;
};

}  // namespace nlg
#endif  // NLG_IRRADIANCE_BATCH_ONCE

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {

using Buffers = LookUpScratch::Buffers;

HWY_INLINE size_t padded(size_t count, size_t lanes) { return (count + lanes - 1) / lanes * lanes; }

// The first `count` lanes, in memory that holds a whole vector.
HWY_INLINE void storeFirst(FloatTag d, Floats value, float* to, size_t count) {
  hn::BlendedStore(value, hn::FirstN(d, count), d, to);
}

// Local coordinates of a vector of positions at a corner, and what bounds and scales its function there.
struct CornerLanes {
  Floats local[3], tent, ratio;
};

HWY_INLINE CornerLanes cornerLanes(FloatTag d, const Buffers& b, size_t position, uint32_t corner, float cell_per_spacing) {
  CornerLanes lanes;
  const Floats one = hn::Set(d, 1.0f), scale = hn::Set(d, cell_per_spacing);
  lanes.tent = lanes.ratio = one;
  for (uint32_t axis = 0; axis < 3; ++axis) {
    const Floats from_low = hn::LoadU(d, &b.from_low[axis][position]);
    const bool is_high = corner >> axis & 1;
    const Floats distance = is_high ? hn::Sub(one, from_low) : from_low;
    const Floats local = hn::Mul(distance, scale), to_border = hn::Sub(one, local);
    lanes.local[axis] = is_high ? hn::Neg(local) : local;
    lanes.tent = hn::Mul(lanes.tent, to_border);
    if (cell_per_spacing < 1.0f) lanes.ratio = hn::Mul(lanes.ratio, hn::Div(hn::Sub(one, distance), to_border));
  }
  return lanes;
}

// The bare tents of one corner of a run.
void addTents(Buffers& b, const CellRun& run, uint32_t corner) {
  const FloatTag d;
  const size_t lanes = hn::Lanes(d);
  for (size_t i = 0; i < run.count; i += lanes) {
    const CornerLanes at = cornerLanes(d, b, run.first + i, corner, run.corners.cell_per_spacing[corner]);
    const size_t count = std::min(lanes, run.count - i);
    storeFirst(d, hn::Mul(at.tent, at.ratio), &b.weight[corner][run.first + i], count);
    storeFirst(d, hn::Zero(d), &b.residue[corner][run.first + i], count);
  }
}

template <NetworkShape kShape>
void evaluateStage(const Representation& representation, size_t count, const float* HWY_RESTRICT theta, Buffers& b) {
  const FloatTag d;
  const Floats slope = hn::Set(d, representation.slope);
  const bool tent_factor = representation.tentFactor();
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    const Floats x = hn::Load(d, &b.stage.x[i]), y = hn::Load(d, &b.stage.y[i]), z = hn::Load(d, &b.stage.z[i]);
    Hidden<kShape, 1> hidden;
    Floats output;
    forwardNetwork<kShape, 1>(d, theta, slope, &x, &y, &z, hidden, &output);
    output = outputValue<kShape.output>(d, output).value;
    if (tent_factor) output = hn::Mul(output, hn::Load(d, &b.stage.tent[i]));
    hn::Store(output, d, &b.value[i]);
  }
}

void evaluateStaged(const Representation& representation, size_t count, const float* theta, Buffers& b) {
  if (representation.isField()) {
    b.stage.count = static_cast<int>(count);
    b.stage.padded_count = static_cast<int>(padded(count, kMaxLanes));
    evaluateField(representation.resolution, b.stage, theta, b.value);
    return;
  }
  withNetworkShape(representation, [&]<NetworkShape kShape>() { evaluateStage<kShape>(representation, count, theta, b); });
}

// Items of one function, as many as the stage holds: their positions side by side, evaluated, and their weights put where they
// belong.
void addFunctions(const LightGrid& grid, const RunItem* items, size_t item_count, Buffers& b) {
  const FloatTag d;
  const size_t lanes = hn::Lanes(d);
  size_t staged = 0;
  for (size_t k = 0; k < item_count; ++k) {
    const CellRun& run = b.runs[items[k].corner_of_run / 8];
    const uint32_t corner = items[k].corner_of_run % 8;
    for (size_t i = 0; i < run.count; i += lanes) {
      const CornerLanes at = cornerLanes(d, b, run.first + i, corner, run.corners.cell_per_spacing[corner]);
      hn::StoreU(at.local[0], d, &b.stage.x[staged + i]);
      hn::StoreU(at.local[1], d, &b.stage.y[staged + i]);
      hn::StoreU(at.local[2], d, &b.stage.z[staged + i]);
      hn::StoreU(at.tent, d, &b.stage.tent[staged + i]);
      const size_t count = std::min(lanes, run.count - i);
      storeFirst(d, at.ratio, &b.weight[corner][run.first + i], count);
    }
    staged += run.count;
  }
  const Representation& representation = grid.representations[grid.function_representation[items[0].function]];
  evaluateStaged(representation, staged, grid.functionTheta(items[0].function), b);
  const Floats zero = hn::Zero(d), residue = hn::Set(d, representation.residue());
  staged = 0;
  for (size_t k = 0; k < item_count; ++k) {
    const CellRun& run = b.runs[items[k].corner_of_run / 8];
    const uint32_t corner = items[k].corner_of_run % 8;
    for (size_t i = 0; i < run.count; i += lanes) {
      const Floats value = hn::LoadU(d, &b.value[staged + i]), tent = hn::LoadU(d, &b.stage.tent[staged + i]);
      // what is no number is no weight either
      const Floats bounded = hn::IfThenElse(hn::Gt(value, zero), hn::Min(value, tent), zero);
      float* weight = &b.weight[corner][run.first + i];
      const size_t count = std::min(lanes, run.count - i);
      storeFirst(d, hn::Mul(bounded, hn::LoadU(d, weight)), weight, count);
      storeFirst(d, residue, &b.residue[corner][run.first + i], count);
    }
    staged += run.count;
  }
}

// Items of each function that follow one another, in pieces that the stage holds.
void addAllFunctions(const LightGrid& grid, Buffers& b) {
  size_t first = 0;
  while (first < b.item_count) {
    size_t end = first, staged = 0;
    for (; end < b.item_count && b.items[end].function == b.items[first].function; ++end) {
      const size_t count = b.runs[b.items[end].corner_of_run / 8].count;
      if (staged + count > kStageSize) break;
      staged += count;
    }
    addFunctions(grid, &b.items[first], end - first, b);
    first = end;
  }
}

// Takes residues off and divides by the sum; share_sum becomes 0 where nothing is left.
void normalise(Buffers& b, size_t count) {
  const FloatTag d;
  const Floats half = hn::Set(d, 0.5f), least = hn::Set(d, kLeastWeight), zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    Floats weight[8], largest = zero, sum = zero;
#pragma GCC unroll 8
    for (int c = 0; c < 8; ++c) {
      weight[c] = hn::Load(d, &b.weight[c][i]);
      largest = hn::Max(largest, weight[c]);
    }
    const Floats most = hn::Mul(half, largest);
#pragma GCC unroll 8
    for (int c = 0; c < 8; ++c) {
      weight[c] = hn::Sub(weight[c], hn::Min(hn::Load(d, &b.residue[c][i]), most));
      weight[c] = hn::IfThenElseZero(hn::Ge(weight[c], least), weight[c]);
      sum = hn::Add(sum, weight[c]);
    }
    hn::Store(sum, d, &b.share_sum[i]);
    const Floats divisor = hn::IfThenElse(hn::Gt(sum, zero), sum, one);
#pragma GCC unroll 8
    for (int c = 0; c < 8; ++c) hn::Store(hn::Div(weight[c], divisor), d, &b.weight[c][i]);
  }
}

// Blends of light, and what irradiance makes of them. Vectors hold whole coefficients: as many triples of channels as fit.
constexpr size_t kTriples = hn::MaxLanes(FloatTag()) >= 3 ? hn::MaxLanes(FloatTag()) / 3 * 3 : 1;
constexpr size_t kPieces = (kShFloats + kTriples - 1) / kTriples;

struct LightLanes {
  Floats piece[kPieces];
};

constexpr size_t kLastPiece = (kPieces - 1) * kTriples;  // its first float
// every other piece is followed by as many floats as a vector has
static_assert(kLastPiece - kTriples + hn::MaxLanes(FloatTag()) <= kShFloats);

// Floats of piece p. Lanes from kTriples on hold anything.
HWY_INLINE Floats loadPiece(FloatTag d, const float* light_9x3, size_t p) {
  if (p + 1 < kPieces) return hn::LoadU(d, light_9x3 + p * kTriples);
#if HWY_MEM_OPS_MIGHT_FAULT
  alignas(64) float floats[hn::MaxLanes(FloatTag())] = {};
  std::memcpy(floats, light_9x3 + kLastPiece, (kShFloats - kLastPiece) * sizeof(float));
  return hn::Load(d, floats);
#else
  return hn::MaskedLoad(hn::FirstN(d, kShFloats - kLastPiece), d, light_9x3 + kLastPiece);
#endif
}

HWY_INLINE void storeLight(FloatTag d, const LightLanes& light, float* light_9x3) {
  for (size_t p = 0; p + 1 < kPieces; ++p) hn::StoreU(light.piece[p], d, light_9x3 + p * kTriples);
  alignas(64) float floats[hn::MaxLanes(FloatTag())];
  hn::Store(light.piece[kPieces - 1], d, floats);
  std::memcpy(light_9x3 + kLastPiece, floats, (kShFloats - kLastPiece) * sizeof(float));
}

HWY_INLINE LightLanes blend(FloatTag d, const LightGrid& grid, const Buffers& b, const CellCorners& corners, size_t position) {
  LightLanes light;
  for (size_t p = 0; p < kPieces; ++p) light.piece[p] = hn::Zero(d);
  for (int c = 0; c < 8; ++c) {
    const float share = b.weight[c][position];
    const float* from = grid.probeLight(corners.probe[c]);
#pragma GCC unroll 9
    for (size_t p = 0; p < kPieces; ++p) light.piece[p] = hn::MulAdd(hn::Set(d, share), loadPiece(d, from, p), light.piece[p]);
  }
  return light;
}

HWY_INLINE void storeIrradiance(FloatTag d, const LightLanes& light, const float* normal_3, float* rgb_3) {
  const std::array<float, kShCount> basis = shBasis(normal_3[0], normal_3[1], normal_3[2]);
  float factors[kLastPiece + hn::MaxLanes(FloatTag())] = {};  // a coefficient's, once a channel
  for (size_t i = 0; i < kShFloats; ++i) factors[i] = kCosineBand[i / kShChannels] * basis[i / kShChannels];
  if constexpr (kTriples == 1) {
    float sum[kShChannels] = {};
    for (size_t p = 0; p < kPieces; ++p) sum[p % kShChannels] += factors[p] * hn::GetLane(light.piece[p]);
    for (int c = 0; c < kShChannels; ++c) rgb_3[c] = std::max(0.0f, sum[c]);
  } else {
    Floats sum = hn::Zero(d);
#pragma GCC unroll 9
    for (size_t p = 0; p < kPieces; ++p) sum = hn::MulAdd(hn::LoadU(d, factors + p * kTriples), light.piece[p], sum);
    alignas(64) float lanes[hn::MaxLanes(FloatTag())];
    hn::Store(sum, d, lanes);
    for (size_t c = 0; c < kShChannels; ++c) {
      float total = lanes[c];
      for (size_t i = c + kShChannels; i < kTriples; i += kShChannels) total += lanes[i];
      rgb_3[c] = std::max(0.0f, total);
    }
  }
}

// Of all positions in a run, where functions have weight; the others are for the caller.
void lightRun(const LightGrid& grid, const Buffers& b, const CellRun& run, const BatchSlice& slice) {
  const FloatTag d;
  for (size_t i = run.first; i < run.first + run.count; ++i) {
    if (b.share_sum[i] == 0.0f) continue;
    const LightLanes light = blend(d, grid, b, run.corners, i);
    slice.status[i] = LightStatus::lit;
    if (slice.normals_3 != nullptr) {
      storeIrradiance(d, light, slice.normals_3 + 3 * i, slice.result + 3 * i);
    } else {
      storeLight(d, light, slice.result + kShFloats * i);
    }
  }
}

// places, runs and items are there.
void lightBlock(const LightGrid& grid, const BatchSlice& slice, Buffers& b) {
  for (size_t r = 0; r < b.run_count; ++r) {
    const CellRun& run = b.runs[r];
    for (uint32_t c = 0; c < 8; ++c) {
      const uint32_t function = grid.probe_function[run.corners.probe[c]];
      if (function == kFreeSpace) addTents(b, run, c);
      if (function != kNoWeight) continue;
      std::fill_n(&b.weight[c][run.first], run.count, 0.0f);
      std::fill_n(&b.residue[c][run.first], run.count, 0.0f);
    }
  }
  addAllFunctions(grid, b);
  normalise(b, slice.count);
  for (size_t r = 0; r < b.run_count; ++r) lightRun(grid, b, b.runs[r], slice);
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(lightBlock);

namespace {

// Cells, runs of positions in one cell, and items of all corners that have a function. Positions in no cell are in no run.
void findRuns(const LightGrid& grid, const BatchSlice& slice, LookUpScratch::Buffers& b) {
  grid.tree.findCells(slice.positions_m, slice.count, b.places.data());
  b.run_count = b.item_count = 0;
  for (uint32_t i = 0; i < slice.count; ++i) {
    const CellPlace& place = b.places[i];
    for (int axis = 0; axis < 3; ++axis) b.from_low[axis][i] = place.from_low[axis];
    if (place.edge == 0) continue;
    CellRun* last = b.run_count > 0 ? &b.runs[b.run_count - 1] : nullptr;
    const bool goes_on = last != nullptr && last->first + last->count == i && last->count < kMaxRun &&
                         b.places[last->first].first_slot == place.first_slot;
    if (goes_on) {
      ++last->count;
      continue;
    }
    b.runs[b.run_count] = {i, 1, grid.tree.cornersOf(place)};
    for (uint32_t c = 0; c < 8; ++c) {
      const uint32_t function = grid.probe_function[b.runs[b.run_count].corners.probe[c]];
      if (function != kFreeSpace && function != kNoWeight)
        b.items[b.item_count++] = {function, static_cast<uint32_t>(8 * b.run_count) + c};
    }
    ++b.run_count;
  }
}

// By function, and by place in the list where that is the same: counting sort of one byte after another.
void sortItems(LookUpScratch::Buffers& b) {
  uint32_t differing = 0;
  for (size_t i = 0; i < b.item_count; ++i) differing |= b.items[i].function ^ b.items[0].function;
  for (int shift = 0; shift < 32; shift += 8) {
    if ((differing >> shift & 0xff) == 0) continue;
    std::array<uint32_t, 256> place{};
    for (size_t i = 0; i < b.item_count; ++i) ++place[b.items[i].function >> shift & 0xff];
    uint32_t next = 0;
    for (uint32_t& count : place) next += std::exchange(count, next);
    for (size_t i = 0; i < b.item_count; ++i) b.sorted[place[b.items[i].function >> shift & 0xff]++] = b.items[i];
    std::copy_n(b.sorted.begin(), b.item_count, b.items.begin());
  }
}

void lookUpOne(const LightGrid& grid, const BatchSlice& slice, size_t i) {
  slice.status[i] = slice.normals_3 != nullptr ? lookUpIrradiance(grid, slice.positions_m[i], slice.normals_3 + kShChannels * i,
                                                                  slice.result + kShChannels * i)
                                               : lookUpLight(grid, slice.positions_m[i], slice.result + kShFloats * i);
}

void lookUpBlock(const LightGrid& grid, const BatchSlice& slice, LookUpScratch::Buffers& b) {
  findRuns(grid, slice, b);
  sortItems(b);
  HWY_DYNAMIC_DISPATCH(lightBlock)(grid, slice, b);
  // the few that vectors leave over: outside, without weight, without a direction
  for (size_t i = 0; i < slice.count; ++i) {
    const bool is_direction = slice.normals_3 == nullptr || isDirection(slice.normals_3 + kShChannels * i);
    if (b.places[i].edge == 0 || b.share_sum[i] == 0.0f || !is_direction) lookUpOne(grid, slice, i);
  }
}

void lookUpAll(const LightGrid& grid, const BatchSlice& list, LookUpScratch::Buffers& b) {
  const size_t result_size = list.normals_3 != nullptr ? kShChannels : kShFloats;
  for (size_t first = 0; first < list.count; first += kBlockSize) {
    const BatchSlice slice{list.positions_m + first, list.normals_3 != nullptr ? list.normals_3 + kShChannels * first : nullptr,
                           std::min(kBlockSize, list.count - first), list.result + result_size * first, list.status + first};
    if (!grid.light.empty()) {
      lookUpBlock(grid, slice, b);
    } else {
      for (size_t i = 0; i < slice.count; ++i) lookUpOne(grid, slice, i);
    }
  }
}

}  // namespace

LookUpScratch::LookUpScratch() : buffers_(std::make_unique<Buffers>()) {}
LookUpScratch::~LookUpScratch() = default;
LookUpScratch::LookUpScratch(LookUpScratch&&) noexcept = default;
LookUpScratch& LookUpScratch::operator=(LookUpScratch&&) noexcept = default;

void lookUpIrradiances(const LightGrid& grid, const PositionM* positions_m, const float* normals_3, size_t count, float* rgb_3,
                       LightStatus* status, LookUpScratch* scratch) {
  lookUpAll(grid, {positions_m, normals_3, count, rgb_3, status}, scratch->buffers());
}

void lookUpIrradiances(const LightGrid& grid, const PositionM* positions_m, const float* normals_3, size_t count, float* rgb_3,
                       LightStatus* status) {
  LookUpScratch scratch;
  lookUpIrradiances(grid, positions_m, normals_3, count, rgb_3, status, &scratch);
}

void lookUpLights(const LightGrid& grid, const PositionM* positions_m, size_t count, float* light_9x3, LightStatus* status,
                  LookUpScratch* scratch) {
  lookUpAll(grid, {positions_m, nullptr, count, light_9x3, status}, scratch->buffers());
}

}  // namespace nlg
#endif  // HWY_ONCE
