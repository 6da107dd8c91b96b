// lookUpIrradiances: a block of positions at a time.
//
// Neighbours in the list that share a cell make a run, and a block's runs are brought into the order of their cells: whatever the
// list was, what follows one another then stands in one place of the level. Positions in that order are cut into chunks whose
// weights, runs and items stay in the level-2 cache. A run has 8 items, one a corner, and a chunk's items are sorted by their
// function: each theta is read once a chunk and runs on vectors of positions, gathered on a stage. Codes need neither sorting nor a stage:
// what their look-up reads is two words of a brick, and lanes may read different ones. Then weights become shares for a vector of positions at
// once, and the 27 numbers of light are blended for one position after another, since 8 probes are what neighbours need not share.
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "nlg/look_up.h"
#include "runtime_eval/evaluator/dictionary.h"
#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/evaluator/product_field.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/light_grid/look_up_batch.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include <hwy/cache_control.h>

#include "runtime_eval/evaluator/tiny_network-inl.h"

#ifndef NLG_IRRADIANCE_BATCH_ONCE
#define NLG_IRRADIANCE_BATCH_ONCE
namespace nlg {

constexpr size_t kBlockSize = 16384;  // positions that are sorted together
constexpr size_t kChunkSize = 2048;   // positions that share functions
constexpr size_t kMaxRun = 128;       // positions of a run
constexpr size_t kStageSize = 1024;   // positions at corners that are evaluated together
constexpr size_t kPlacesAtOnce = 512;
constexpr size_t kRunsAhead = 4;       // whose light is fetched
constexpr size_t kListRunsAhead = 16;  // whose positions are fetched
constexpr size_t kMaxLanes = 16;
constexpr size_t kPadded = kChunkSize + kMaxLanes;  // vectors may write past the last position

// Neighbours in the list in one cell: what is sorted, by first_slot.
struct ListRun {
  uint32_t first_slot, first;  // names the cell; position of the block
  uint16_t count;
  uint8_t edge, cell_log2;  // as CellPlace has them
};
static_assert(kMaxRun <= UINT16_MAX);

// Positions of a chunk in one cell, side by side.
struct CellRun {
  uint32_t first, count, first_slot;
  uint8_t free_corners, dark_corners, code_corners;  // bits: probes in free space, without weight, with a code
  CellCorners corners;
};

// One corner of one run that has a function, but no code: what is sorted, by function. All that its evaluation needs of the run.
struct RunItem {
  uint32_t function;
  uint16_t first;  // position of the chunk
  uint8_t count;
  uint8_t corner : 4, spacing_log2 : 4;  // as CellCorners has them
};
static_assert(sizeof(RunItem) == 8 && kChunkSize <= 1 << 16 && kMaxRun < 1 << 8);

// Items of one function on the stage.
struct StageSegment {
  uint32_t function;
  uint32_t first_item, end_item;
  uint32_t first, end;  // places; first is a multiple of kMaxLanes
};

// Where positions lie in bricks of one resolution, of probes of one spacing: along each axis, of probes at the cell's low side and at its
// high side. Nodes are multiplied by what a step along their axis is in words of a brick; those along x have kWordShift added.
constexpr size_t kTileSize = kMaxRun;
constexpr size_t kTilePadded = kTileSize + kMaxLanes;
constexpr float kWordShift = 0x1p23f;  // a sum of nodes has its word in its low bits
struct BrickPlaces {
  alignas(64) float node[6][kTilePadded], share[6][kTilePadded];
};

// The brick of one corner of one run.
struct TileBrick {
  const uint32_t* quads;
  uint16_t place, count;  // corner * kTilePadded + position of the tile; positions
};
static_assert(8 * kTilePadded <= UINT16_MAX);

// Runs of a chunk whose codes are evaluated together.
struct CodeTile {
  BrickPlaces places;
  // by corner and position
  alignas(64) uint32_t word[8 * kTilePadded];      // from the first of the brick
  alignas(64) uint32_t cell[2 * 8 * kTilePadded];  // the two words there
  alignas(64) float step[8 * kTilePadded];         // 0 where no brick is
  // of one corner of one run that is unlike the others
  BrickPlaces odd_places;
  alignas(64) uint32_t odd_word[kTilePadded], odd_cell[2 * kTilePadded];
  std::array<TileBrick, 8 * kTileSize> bricks;
  size_t brick_count;
};

struct LookUpScratch::Buffers {
  CodeTile tile;

  // of a block, in the order of the list
  std::array<CellPlace, kPlacesAtOnce> places;
  alignas(64) float block_from_low[4 * kBlockSize];  // x, y, z, 0
  std::array<ListRun, kBlockSize> list_runs, spare_runs;
  size_t list_run_count;
  const ListRun* sorted_runs;

  // of a chunk, in the order of cells
  size_t position_count, run_count, item_count;
  std::array<uint32_t, kChunkSize> order;  // position of the block
  alignas(64) float from_low[4 * kPadded];
  alignas(64) float weight[8][kPadded];  // by corner: shares of the tent first, those of the blend in the end
  alignas(64) float certainty[kPadded];  // of the blend
  std::array<CellRun, kChunkSize> runs;
  std::array<RunItem, 8 * kChunkSize> items, spare_items;
  const RunItem* sorted_items;

  // of a stage
  size_t segment_count, staged_count;
  std::array<StageSegment, kStageSize / kMaxLanes> segments;
  alignas(64) float stage[4 * (kStageSize + kMaxLanes)];  // local x, y, z, 0
  alignas(64) float value[kStageSize + kMaxLanes];
  PointSet field_points;  // of a segment, for product fields

  Buffers() {
    std::fill_n(from_low, std::size(from_low), 0.0f);
    std::fill_n(stage, std::size(stage), 0.0f);
    std::fill_n(tile.cell, std::size(tile.cell), 0u);
    std::fill_n(tile.odd_cell, std::size(tile.odd_cell), 0u);
    for (AlignedFloats* list : {&field_points.x, &field_points.y, &field_points.z}) list->assign(kStageSize, 0.0f);
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

// Of one position of the slice, by itself.
void lookUpOne(const LightGrid& grid, const BatchSlice& slice, size_t i);

// By key, and by place in the list where that is the same: counting sort of one byte after another.
//
// spare     as many as items; either of the two holds the result
// largest   of the keys
template <class Item, class Key>
const Item* sortByKey(Item* items, Item* spare, size_t count, uint32_t largest, const Key& key) {
  for (int shift = 0; count > 1 && shift < 32 && largest >> shift != 0; shift += 8) {
    std::array<uint32_t, 256> place{};
    for (size_t i = 0; i < count; ++i) ++place[key(items[i]) >> shift & 0xff];
    uint32_t next = 0;
    for (uint32_t& bucket : place) next += std::exchange(bucket, next);
    for (size_t i = 0; i < count; ++i) spare[place[key(items[i]) >> shift & 0xff]++] = items[i];
    std::swap(items, spare);
  }
  return items;
}

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

// One value for a corner of all positions of a run.
template <class Run>
HWY_INLINE void fillRun(FloatTag d, const Run& run, float value, float* of_corner) {
  const Floats values = hn::Set(d, value);
  for (size_t i = 0; i < run.count; i += hn::Lanes(d))
    storeFirst(d, values, of_corner + run.first + i, std::min(hn::Lanes(d), run.count - i));
}

// All corners as those in free space are, which have all of their tent; then those that have no weight.
void fillWithoutFunction(Buffers& b) {
  const FloatTag d;
  const Floats one = hn::Set(d, 1.0f);
  for (size_t c = 0; c < 8; ++c) {
    for (size_t i = 0; i < b.position_count; i += hn::Lanes(d)) hn::Store(one, d, &b.weight[c][i]);
  }
  for (size_t r = 0; r < b.run_count; ++r) {
    const CellRun& run = b.runs[r];
    for (uint32_t left = run.dark_corners; left != 0; left &= left - 1) fillRun(d, run, 0.0f, b.weight[std::countr_zero(left)]);
  }
}

// From a position in a cell to local coordinates of the probe at one corner: (turn * from_low + shift) * sign * the cell's side over the
// probe's spacing. The fourth number is 0.
struct CornerMap {
  alignas(16) float turn[4], shift[4], sign[4];
};

// By CellCorners::spacing_log2.
constexpr float kCellPerSpacing[] = {1.0f, 0x1p-1f, 0x1p-2f, 0x1p-3f, 0x1p-4f, 0x1p-5f, 0x1p-6f};

constexpr std::array<CornerMap, 8> kCornerMaps = [] {
  std::array<CornerMap, 8> maps{};
  for (int corner = 0; corner < 8; ++corner) {
    for (int axis = 0; axis < 3; ++axis) {
      const bool is_high = corner >> axis & 1;
      maps[corner].turn[axis] = maps[corner].sign[axis] = is_high ? -1.0f : 1.0f;
      maps[corner].shift[axis] = is_high ? 1.0f : 0.0f;
    }
    maps[corner].turn[3] = maps[corner].shift[3] = maps[corner].sign[3] = 0.0f;
  }
  return maps;
}();

// Lanes i, i + 1, … of four numbers that go round.
HWY_INLINE Floats loadFour(FloatTag d, const float* four, size_t i) {
  return hn::MaxLanes(d) < 4 ? hn::Set(d, four[i % 4]) : hn::LoadDup128(d, four);
}

// A corner of a run, from place `to` on. Up to a vector more is written.
HWY_INLINE void stageItem(const RunItem& item, size_t to, Buffers& b) {
  const FloatTag d;
  const CornerMap& map = kCornerMaps[item.corner];
  const Floats side = hn::Set(d, kCellPerSpacing[item.spacing_log2]);
  const float* from_low = b.from_low + 4 * size_t{item.first};
  float* stage = b.stage + 4 * to;
  for (size_t i = 0; i < 4 * size_t{item.count}; i += hn::Lanes(d)) {
    const Floats scale = hn::Mul(loadFour(d, map.sign, i), side);
    const Floats distance = hn::MulAdd(loadFour(d, map.turn, i), hn::LoadU(d, from_low + i), loadFour(d, map.shift, i));
    hn::StoreU(hn::Mul(distance, scale), d, stage + i);
  }
}

// A vector of the stage.
struct StageLanes {
  Floats x, y, z;  // local coordinates
};

HWY_INLINE StageLanes loadStage(FloatTag d, const Buffers& b, size_t place) {
  StageLanes at;
  Floats unused;
  hn::LoadInterleaved4(d, b.stage + 4 * place, at.x, at.y, at.z, unused);
  return at;
}

// To divide by: at other probes' places it would be 0. Below kLeastWeight whatever the share is gives no weight.
HWY_INLINE Floats tentAt(FloatTag d, const StageLanes& at) {
  const Floats one = hn::Set(d, 1.0f);
  const Floats tent = hn::Mul(hn::Mul(hn::Sub(one, hn::Abs(at.x)), hn::Sub(one, hn::Abs(at.y))), hn::Sub(one, hn::Abs(at.z)));
  return hn::Max(tent, hn::Set(d, 0.5f * kLeastWeight));
}

template <NetworkShape kShape>
void evaluateNetworks(const Representation& representation, const StageSegment& segment, const float* HWY_RESTRICT theta,
                      Buffers& b) {
  const FloatTag d;
  const Floats slope = hn::Set(d, representation.slope);
  const bool tent_factor = representation.tentFactor();
  for (size_t i = segment.first; i < segment.end; i += hn::Lanes(d)) {
    const StageLanes at = loadStage(d, b, i);
    Hidden<kShape, 1> hidden;
    Floats output;
    forwardNetwork<kShape, 1>(d, theta, slope, &at.x, &at.y, &at.z, hidden, &output);
    output = outputValue<kShape.output>(d, output).value;
    if (!tent_factor) output = hn::Div(output, tentAt(d, at));
    hn::Store(output, d, b.value + i);
  }
}

void evaluateFields(const Representation& representation, const StageSegment& segment, const float* theta, Buffers& b) {
  const FloatTag d;
  PointSet& points = b.field_points;
  const size_t count = segment.end - segment.first;
  points.count = static_cast<int>(count);
  points.padded_count = static_cast<int>(padded(count, kMaxLanes));
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    const StageLanes at = loadStage(d, b, segment.first + i);
    hn::Store(at.x, d, &points.x[i]);
    hn::Store(at.y, d, &points.y[i]);
    hn::Store(at.z, d, &points.z[i]);
  }
  float* value = b.value + segment.first;
  evaluateField(representation.resolution, points, theta, value);
  for (size_t i = 0; i < count; i += hn::Lanes(d))
    hn::Store(hn::Div(hn::Load(d, value + i), tentAt(d, loadStage(d, b, segment.first + i))), d, value + i);
}

const Representation& representationOf(const LightGrid& grid, uint32_t function) {
  return grid.representations[grid.function_representation[function]];
}

void evaluateSegment(const LightGrid& grid, const StageSegment& segment, Buffers& b) {
  const Representation& representation = representationOf(grid, segment.function);
  const float* theta = grid.functionTheta(segment.function);
  if (representation.isField()) {
    evaluateFields(representation, segment, theta, b);
    return;
  }
  withNetworkShape(representation, [&]<NetworkShape kShape>() { evaluateNetworks<kShape>(representation, segment, theta, b); });
}

// Values of a segment to where they belong.
void takeFromStage(const StageSegment& segment, Buffers& b) {
  const FloatTag d;
  const float* value = b.value + segment.first;
  for (size_t k = segment.first_item; k < segment.end_item; ++k) {
    const RunItem& item = b.sorted_items[k];
    float* weight = &b.weight[item.corner][item.first];
    for (size_t i = 0; i < item.count; i += hn::Lanes(d))
      storeFirst(d, hn::LoadU(d, value + i), weight + i, std::min(hn::Lanes(d), item.count - i));
    value += item.count;
  }
}

void finishStage(const LightGrid& grid, Buffers& b) {
  for (size_t s = 0; s < b.segment_count; ++s) evaluateSegment(grid, b.segments[s], b);
  for (size_t s = 0; s < b.segment_count; ++s) takeFromStage(b.segments[s], b);
  b.segment_count = b.staged_count = 0;
}

void prefetchTheta(const LightGrid& grid, uint32_t function) {
  const float* theta = grid.functionTheta(function);
  const size_t count = grid.theta_begin[function + 1] - grid.theta_begin[function];
  for (size_t i = 0; i < count; i += 16) hwy::Prefetch(theta + i);
}

// All items: a stage full at a time, one segment a function.
void addFunctions(const LightGrid& grid, Buffers& b) {
  b.segment_count = b.staged_count = 0;
  for (uint32_t k = 0; k < b.item_count; ++k) {
    const RunItem& item = b.sorted_items[k];
    bool goes_on = b.segment_count > 0 && b.segments[b.segment_count - 1].function == item.function;
    if (!goes_on) b.staged_count = padded(b.staged_count, kMaxLanes);
    if (b.staged_count + item.count > kStageSize) {
      finishStage(grid, b);
      goes_on = false;
    }
    const auto first = static_cast<uint32_t>(b.staged_count);
    if (!goes_on) {
      b.segments[b.segment_count++] = {item.function, k, k, first, first};
      prefetchTheta(grid, item.function);
    }
    stageItem(item, first, b);
    b.staged_count += item.count;
    b.segments[b.segment_count - 1].end_item = k + 1;
    b.segments[b.segment_count - 1].end = static_cast<uint32_t>(b.staged_count);
  }
  finishStage(grid, b);
}

// Of positions of the chunk.
void placeInBricks(size_t first, size_t count, int resolution, int spacing_log2, const Buffers& b, BrickPlaces& places) {
  const FloatTag d;
  const float middle = 0.5f * static_cast<float>(resolution - 1);
  const Floats half = hn::Set(d, middle), nodes_a_side = hn::Set(d, middle * kCellPerSpacing[spacing_log2]),
               one = hn::Set(d, 1.0f), last = hn::Set(d, static_cast<float>(resolution - 2)), zero = hn::Zero(d),
               shift = hn::Set(d, kWordShift);
  const Floats words[3] = {one, hn::Set(d, static_cast<float>(resolution)),
                           hn::Set(d, static_cast<float>(resolution * (resolution - 1)))};
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    Floats from_low[3], unused;
    hn::LoadInterleaved4(d, b.from_low + 4 * (first + i), from_low[0], from_low[1], from_low[2], unused);
    // along each axis as the probe at the low side sees it, and as the one at the high side does
#pragma GCC unroll 6
    for (int k = 0; k < 6; ++k) {
      const int axis = k / 2;
      const Floats at = k % 2 == 0 ? hn::MulAdd(nodes_a_side, from_low[axis], half)
                                   : hn::NegMulAdd(nodes_a_side, hn::Sub(one, from_low[axis]), half);
      const Floats node = hn::Min(hn::Floor(at), last);
      hn::Store(hn::MulAdd(node, words[axis], axis == 0 ? shift : zero), d, &places.node[k][i]);
      hn::Store(hn::Sub(at, node), d, &places.share[k][i]);
    }
  }
}

// Of a corner along each axis: whose of the six places is its own.
struct CornerPlace {
  size_t x, y, z;
  explicit CornerPlace(size_t corner) : x(corner & 1), y(2 + (corner >> 1 & 1)), z(4 + (corner >> 2)) {}
};

HWY_INLINE void storeWords(FloatTag d, const BrickPlaces& places, const CornerPlace& at, size_t i, uint32_t* word) {
  const hn::RebindToUnsigned<FloatTag> du;
  const Floats sum = hn::Add(hn::Add(hn::Load(d, &places.node[at.x][i]), hn::Load(d, &places.node[at.y][i])),
                             hn::Load(d, &places.node[at.z][i]));
  hn::Store(hn::Sub(hn::BitCast(du, sum), hn::BitCast(du, hn::Set(d, kWordShift))), du, word + i);
}

// Cells one after another: a gather is no faster.
HWY_INLINE void readCells(const uint32_t* HWY_RESTRICT quads, const uint32_t* HWY_RESTRICT word, size_t count,
                          uint32_t* HWY_RESTRICT cell) {
  for (size_t i = 0; i < count; ++i) std::memcpy(cell + 2 * i, quads + word[i], 2 * sizeof(uint32_t));
}

// A node of a word of quads: byte kByte.
template <int kByte>
HWY_INLINE Floats nodeOf(FloatTag d, hn::Vec<hn::RebindToUnsigned<FloatTag>> quads) {
  const hn::RebindToSigned<FloatTag> di;
  return hn::ConvertTo(d, hn::ShiftRight<24>(hn::ShiftLeft<24 - 8 * kByte>(hn::BitCast(di, quads))));
}

HWY_INLINE Floats between(Floats low, Floats high, Floats share) { return hn::MulAdd(share, hn::Sub(high, low), low); }

// A vector of shares of tents, out of cells.
HWY_INLINE Floats cellShares(FloatTag d, const uint32_t* cell, const BrickPlaces& places, const CornerPlace& at, size_t i,
                             Floats step) {
  const hn::RebindToUnsigned<FloatTag> du;
  const Floats x = hn::Load(d, &places.share[at.x][i]), y = hn::Load(d, &places.share[at.y][i]),
               z = hn::Load(d, &places.share[at.z][i]);
  hn::Vec<decltype(du)> low, high;
  hn::LoadInterleaved2(du, cell + 2 * i, low, high);
  const Floats near =
      between(between(nodeOf<0>(d, low), nodeOf<0>(d, high), x), between(nodeOf<1>(d, low), nodeOf<1>(d, high), x), y);
  const Floats far =
      between(between(nodeOf<2>(d, low), nodeOf<2>(d, high), x), between(nodeOf<3>(d, low), nodeOf<3>(d, high), x), y);
  return sigmoid(d, hn::Mul(step, between(near, far, z))).value;
}

// A corner whose brick or spacing is not that of the tile.
void addOddCorner(const CellRun& run, size_t corner, const FunctionBrick& brick, const uint32_t* quads, Buffers& b) {
  const FloatTag d;
  const CornerPlace at(corner);
  BrickPlaces& places = b.tile.odd_places;
  placeInBricks(run.first, run.count, brick.resolution, run.corners.spacing_log2[corner], b, places);
  for (size_t i = 0; i < run.count; i += hn::Lanes(d)) storeWords(d, places, at, i, b.tile.odd_word);
  readCells(quads, b.tile.odd_word, run.count, b.tile.odd_cell);
  const Floats step = hn::Set(d, brick.step);
  for (size_t i = 0; i < run.count; i += hn::Lanes(d))
    storeFirst(d, cellShares(d, b.tile.odd_cell, places, at, i, step), &b.weight[corner][run.first + i],
               std::min(hn::Lanes(d), run.count - i));
}

// Which bricks a tile reads, and their steps; what is read of them comes nearer meanwhile.
void findBricks(const LightGrid& grid, size_t first_run, size_t end_run, int resolution, Buffers& b) {
  const FloatTag d;
  CodeTile& tile = b.tile;
  const uint32_t first_position = b.runs[first_run].first;
  size_t brick_count = 0;
  for (size_t r = first_run; r < end_run; ++r) {
    const CellRun& run = b.runs[r];
    const size_t first = run.first - first_position, count = run.count;
    for (size_t corner = 0; corner < 8; ++corner) {
      const size_t place = corner * kTilePadded + first;
      Floats step = hn::Zero(d);
      if (run.code_corners >> corner & 1) {
        const FunctionBrick& brick = grid.function_brick[grid.probe_function[run.corners.probe[corner]]];
        const uint32_t* quads = grid.quads.data() + brick.begin;
        // a corner of the tile's resolution and of its cell's own spacing shares the places of the tile
        if (brick.resolution == resolution && run.corners.spacing_log2[corner] == 0) {
          hwy::Prefetch(quads + tile.word[place]);
          tile.bricks[brick_count++] = {quads, static_cast<uint16_t>(place), static_cast<uint16_t>(count)};
          step = hn::Set(d, brick.step);
        } else {
          addOddCorner(run, corner, brick, quads, b);
        }
      }
      // what is too much, the next run or the end of the tile overwrites
      for (size_t i = 0; i < count; i += hn::Lanes(d)) hn::StoreU(step, d, tile.step + place + i);
    }
  }
  tile.brick_count = brick_count;
}

// Whole runs, of at most kTileSize positions.
void addTile(const LightGrid& grid, size_t first_run, size_t end_run, int resolution, Buffers& b) {
  const FloatTag d;
  const size_t lanes = hn::Lanes(d), first = b.runs[first_run].first,
               count = b.runs[end_run - 1].first + b.runs[end_run - 1].count - first;
  CodeTile& tile = b.tile;
  // first all words, then all cells, then all shares: the fetches of bricks overlap with work on others
  placeInBricks(first, count, resolution, 0, b, tile.places);
  for (size_t corner = 0; corner < 8; ++corner) {
    const CornerPlace at(corner);
    for (size_t i = 0; i < count; i += lanes) storeWords(d, tile.places, at, i, tile.word + corner * kTilePadded);
  }
  findBricks(grid, first_run, end_run, resolution, b);
  for (size_t k = 0; k < tile.brick_count; ++k) {
    const TileBrick brick = tile.bricks[k];
    if (brick.count == 1) {
      std::memcpy(tile.cell + 2 * size_t{brick.place}, brick.quads + tile.word[brick.place], 2 * sizeof(uint32_t));
    } else {
      readCells(brick.quads, tile.word + brick.place, brick.count, tile.cell + 2 * size_t{brick.place});
    }
  }
  for (size_t corner = 0; corner < 8; ++corner) {
    const CornerPlace at(corner);
    const uint32_t* cell = tile.cell + 2 * corner * kTilePadded;
    float *steps = tile.step + corner * kTilePadded, *weight = b.weight[corner] + first;
    hn::StoreU(hn::Zero(d), d, steps + count);
    for (size_t i = 0; i < count; i += lanes) {
      // what has no brick keeps what it has, also behind the last position
      const Floats step = hn::Load(d, steps + i), shares = cellShares(d, cell, tile.places, at, i, step);
      hn::StoreU(hn::IfThenElse(hn::Gt(step, hn::Zero(d)), shares, hn::LoadU(d, weight + i)), d, weight + i);
    }
  }
}

// Of the first codes, to which tiles are made: bricks of another resolution are odd corners. 0 where there are none.
int codeResolution(const LightGrid& grid) {
  for (const Representation& representation : grid.representations) {
    if (representation.isCode()) return representation.resolution;
  }
  return 0;
}

void addCodes(const LightGrid& grid, Buffers& b) {
  const int resolution = codeResolution(grid);
  if (resolution == 0) return;
  for (size_t first = 0, end = 0; first < b.run_count; first = end) {
    uint32_t code_corners = 0;
    size_t count = 0;
    for (; end < b.run_count && count + b.runs[end].count <= kTileSize; ++end) {
      count += b.runs[end].count;
      code_corners |= b.runs[end].code_corners;
    }
    if (code_corners != 0) addTile(grid, first, end, resolution, b);
  }
}

// Bounds shares of tents, takes the residue off, multiplies by the cell's tents, and divides by the sum.
// Weights lack the factor 1 / (1 - residue), which all have.
void normalise(Buffers& b) {
  const FloatTag d;
  const Floats residue = hn::Set(d, kResidue), least = hn::Set(d, kLeastWeight * (1.0f - kResidue)), zero = hn::Zero(d),
               one = hn::Set(d, 1.0f);
  for (size_t i = 0; i < b.position_count; i += hn::Lanes(d)) {
    Floats x, y, z, unused;
    hn::LoadInterleaved4(d, b.from_low + 4 * i, x, y, z, unused);
    // the cell's own tents, which are t ρ of docs/theory/probes.md whatever spacing a probe has
    const Floats low_x = hn::Sub(one, x), low_y = hn::Sub(one, y), low_z = hn::Sub(one, z);
    const Floats to_x[2] = {low_x, hn::Sub(one, low_x)}, to_y[2] = {low_y, hn::Sub(one, low_y)},
                 to_z[2] = {low_z, hn::Sub(one, low_z)};
    const Floats to_xy[4] = {hn::Mul(to_x[0], to_y[0]), hn::Mul(to_x[1], to_y[0]), hn::Mul(to_x[0], to_y[1]),
                             hn::Mul(to_x[1], to_y[1])};
    Floats weight[8], sum = zero, believed = zero;
#pragma GCC unroll 8
    for (int c = 0; c < 8; ++c) {
      const Floats value = hn::Load(d, &b.weight[c][i]);
      // what is no number is no weight either
      const Floats above = hn::Sub(hn::IfThenElseZero(hn::Gt(value, zero), hn::Min(value, one)), residue);
      weight[c] = hn::Mul(above, hn::Mul(to_xy[c % 4], to_z[c / 4]));
      weight[c] = hn::IfThenElseZero(hn::Ge(weight[c], least), weight[c]);
      sum = hn::Add(sum, weight[c]);
      believed = hn::MulAdd(weight[c], above, believed);
    }
    // certainty as in docs/theory/probes.md; shares sum to 1 here, since positions that are less than certain are looked up alone
    const Floats divisor = hn::IfThenElse(hn::Gt(sum, zero), sum, one);
    const Floats certainty = hn::Min(one, hn::Div(believed, hn::Mul(residue, divisor)));
    hn::Store(certainty, d, &b.certainty[i]);
    const Floats scale = hn::Div(one, divisor);
#pragma GCC unroll 8
    for (int c = 0; c < 8; ++c) hn::Store(hn::Mul(weight[c], scale), d, &b.weight[c][i]);
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

// Light of the probes of a run.
using CornerLights = std::array<const float*, 8>;

HWY_INLINE LightLanes blend(FloatTag d, const CornerLights& lights, const Buffers& b, size_t position) {
  LightLanes light;
  for (size_t p = 0; p < kPieces; ++p) light.piece[p] = hn::Zero(d);
#pragma GCC unroll 8
  for (size_t c = 0; c < 8; ++c) {
    const Floats share = hn::Set(d, b.weight[c][position]);
#pragma GCC unroll 9
    for (size_t p = 0; p < kPieces; ++p) light.piece[p] = hn::MulAdd(share, loadPiece(d, lights[c], p), light.piece[p]);
  }
  return light;
}

// What irradiance takes of each coefficient, as a polynomial of the normal: once a channel, as light lies in memory. Terms are
// 1, x, y, z, xx, yy, zz, xy, yz, xz.
constexpr size_t kTerms = 10;
constexpr size_t kFactorFloats = kLastPiece + hn::MaxLanes(FloatTag());

struct FactorTable {
  alignas(64) float of_term[kTerms][kFactorFloats];  // 0 behind the last coefficient
  bool is_needed[kPieces][kTerms];                   // by any lane of a piece
};

constexpr FactorTable kFactors = [] {
  FactorTable table{};
  // a basis function is a polynomial of degree 2: its terms follow from its values at 0, ±1 on the axes, and sums of two axes
  const auto zero = shBasis(0, 0, 0);
  const std::array<float, kShCount> plus[3] = {shBasis(1, 0, 0), shBasis(0, 1, 0), shBasis(0, 0, 1)},
                                    minus[3] = {shBasis(-1, 0, 0), shBasis(0, -1, 0), shBasis(0, 0, -1)},
                                    both[3] = {shBasis(1, 1, 0), shBasis(0, 1, 1), shBasis(1, 0, 1)};
  for (size_t i = 0; i < kShFloats; ++i) {
    const size_t k = i / kShChannels;
    float term[kTerms] = {zero[k]};
    for (size_t axis = 0; axis < 3; ++axis) {
      const size_t next = (axis + 1) % 3;
      term[1 + axis] = 0.5f * (plus[axis][k] - minus[axis][k]);
      term[4 + axis] = 0.5f * (plus[axis][k] + minus[axis][k]) - zero[k];
      term[7 + axis] = both[axis][k] - plus[axis][k] - plus[next][k] + zero[k];
    }
    for (size_t t = 0; t < kTerms; ++t) {
      table.of_term[t][i] = kCosineBand[k] * term[t];
      table.is_needed[i / kTriples][t] |= term[t] != 0.0f;
    }
  }
  return table;
}();

HWY_INLINE void storeIrradiance(FloatTag d, const LightLanes& light, const float* normal_3, float* rgb_3) {
  const Floats x = hn::Set(d, normal_3[0]), y = hn::Set(d, normal_3[1]), z = hn::Set(d, normal_3[2]);
  const Floats term[kTerms] = {
      hn::Set(d, 1.0f), x, y, z, hn::Mul(x, x), hn::Mul(y, y), hn::Mul(z, z), hn::Mul(x, y), hn::Mul(y, z), hn::Mul(x, z)};
  Floats sum = hn::Zero(d);
  alignas(64) float lanes[kPieces > kShChannels && kTriples == 1 ? kPieces : hn::MaxLanes(FloatTag())];
#pragma GCC unroll 27
  for (size_t p = 0; p < kPieces; ++p) {
    Floats factor = hn::LoadU(d, kFactors.of_term[0] + p * kTriples);
    // what no lane of the piece needs is gone once the loops are unrolled
#pragma GCC unroll 10
    for (size_t t = 1; t < kTerms; ++t) {
      if (kFactors.is_needed[p][t]) factor = hn::MulAdd(hn::LoadU(d, kFactors.of_term[t] + p * kTriples), term[t], factor);
    }
    if constexpr (kTriples == 1) {
      lanes[p] = hn::GetLane(hn::Mul(factor, light.piece[p]));
    } else {
      sum = hn::MulAdd(factor, light.piece[p], sum);
    }
  }
  if constexpr (kTriples > 1) hn::Store(sum, d, lanes);
  float mean[kShChannels];  // coefficient 0
  if constexpr (kTriples > 1) {
    alignas(64) float first[hn::MaxLanes(FloatTag())];
    hn::Store(light.piece[0], d, first);
    std::copy_n(first, kShChannels, mean);
  } else {
    for (size_t c = 0; c < kShChannels; ++c) mean[c] = hn::GetLane(light.piece[c]);
  }
  // lanes of one channel are three apart
  for (size_t c = 0; c < kShChannels; ++c) {
    float total = lanes[c];
    for (size_t i = c + kShChannels; i < (kTriples == 1 ? kPieces : kTriples); i += kShChannels) total += lanes[i];
    rgb_3[c] = std::max({total, kFloorOfMean * mean[c], 0.0f});
  }
}

void prefetchLight(const LightGrid& grid, const CellCorners& corners) {
  for (const uint32_t probe : corners.probe) {
    hwy::Prefetch(grid.probeLight(probe));
    hwy::Prefetch(grid.probeLight(probe) + 16);
  }
}

// Of all positions in a run.
void lightRun(const LightGrid& grid, const Buffers& b, const CellRun& run, const BatchSlice& slice) {
  const FloatTag d;
  CornerLights lights;
  for (size_t c = 0; c < 8; ++c) lights[c] = grid.probeLight(run.corners.probe[c]);
  for (size_t i = run.first; i < run.first + run.count; ++i) {
    const size_t to = b.order[i];
    const bool is_direction = slice.normals_3 == nullptr || isDirection(slice.normals_3 + kShChannels * to);
    // what is less than certain, or has no direction, takes the path of a single look-up
    if (b.certainty[i] < 1.0f || !is_direction) {
      lookUpOne(grid, slice, to);
      continue;
    }
    const LightLanes light = blend(d, lights, b, i);
    slice.status[to] = LightStatus::lit;
    if (slice.normals_3 != nullptr) {
      storeIrradiance(d, light, slice.normals_3 + kShChannels * to, slice.result + kShChannels * to);
    } else {
      storeLight(d, light, slice.result + kShFloats * to);
    }
  }
}

// Positions, runs and items are there.
void lightChunk(const LightGrid& grid, const BatchSlice& slice, Buffers& b) {
  fillWithoutFunction(b);
  addFunctions(grid, b);
  addCodes(grid, b);
  normalise(b);
  for (size_t r = 0; r < b.run_count; ++r) {
    if (r + kRunsAhead < b.run_count) prefetchLight(grid, b.runs[r + kRunsAhead].corners);
    lightRun(grid, b, b.runs[r], slice);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(lightChunk);

void lookUpOne(const LightGrid& grid, const BatchSlice& slice, size_t i) {
  slice.status[i] = slice.normals_3 != nullptr ? lookUpIrradiance(grid, slice.positions_m[i], slice.normals_3 + kShChannels * i,
                                                                  slice.result + kShChannels * i)
                                               : lookUpLight(grid, slice.positions_m[i], slice.result + kShFloats * i);
}

namespace {

// Adds positions from `first` on, whose places have been found, to the runs of the list. Those in no cell are in no run, but done.
void addPlaces(const LightGrid& grid, const BatchSlice& slice, size_t first, size_t count, LookUpScratch::Buffers& b) {
  for (size_t i = 0; i < count; ++i) {
    const CellPlace& place = b.places[i];
    const auto position = static_cast<uint32_t>(first + i);
    if (place.edge == 0) {
      lookUpOne(grid, slice, position);
      continue;
    }
    float* from_low = b.block_from_low + 4 * size_t{position};
    for (int axis = 0; axis < 3; ++axis) from_low[axis] = place.from_low[axis];
    from_low[3] = 0.0f;
    ListRun* last = b.list_run_count > 0 ? &b.list_runs[b.list_run_count - 1] : nullptr;
    const bool goes_on =
        last != nullptr && last->first_slot == place.first_slot && last->first + last->count == position && last->count < kMaxRun;
    if (goes_on) {
      ++last->count;
    } else {
      b.list_runs[b.list_run_count++] = {place.first_slot, position, 1, place.edge, place.cell_log2};
    }
  }
}

void findRuns(const LightGrid& grid, const BatchSlice& slice, LookUpScratch::Buffers& b) {
  b.list_run_count = 0;
  for (size_t first = 0; first < slice.count; first += kPlacesAtOnce) {
    const size_t count = std::min(kPlacesAtOnce, slice.count - first);
    grid.tree.findCells(slice.positions_m + first, count, b.places.data());
    addPlaces(grid, slice, first, count, b);
  }
  uint32_t largest = 0;
  for (size_t r = 0; r < b.list_run_count; ++r) largest = std::max(largest, b.list_runs[r].first_slot);
  b.sorted_runs = sortByKey(b.list_runs.data(), b.spare_runs.data(), b.list_run_count, largest,
                            [](const ListRun& run) { return run.first_slot; });
}

// Items of a run, and which corners have none.
void addItems(const LightGrid& grid, CellRun& run, LookUpScratch::Buffers& b) {
  for (uint32_t c = 0; c < 8; ++c) {
    const uint32_t function = grid.probe_function[run.corners.probe[c]];
    if (function == kFreeSpace) {
      run.free_corners |= static_cast<uint8_t>(1 << c);
    } else if (function == kNoWeight) {
      run.dark_corners |= static_cast<uint8_t>(1 << c);
    } else if (grid.representations[grid.function_representation[function]].isCode()) {
      run.code_corners |= static_cast<uint8_t>(1 << c);
      hwy::Prefetch(&grid.function_brick[function]);
    } else {
      b.items[b.item_count++] = {function, static_cast<uint16_t>(run.first), static_cast<uint8_t>(run.count),
                                 static_cast<uint8_t>(c), run.corners.spacing_log2[c]};
    }
  }
}

void prefetchPosition(const BatchSlice& slice, size_t i, const LookUpScratch::Buffers& b) {
  hwy::Prefetch(b.block_from_low + 4 * i);
  if (slice.normals_3 == nullptr) return;
  hwy::Prefetch(slice.normals_3 + kShChannels * i);
  hwy::Prefetch(slice.result + kShChannels * i);
}

// Sorted runs from `next` on, as many as a chunk holds; returns the first that it does not hold.
size_t fillChunk(const LightGrid& grid, const BatchSlice& slice, size_t next, LookUpScratch::Buffers& b) {
  b.position_count = b.run_count = b.item_count = 0;
  for (; next < b.list_run_count; ++next) {
    const ListRun& from = b.sorted_runs[next];
    if (next + kListRunsAhead < b.list_run_count) prefetchPosition(slice, b.sorted_runs[next + kListRunsAhead].first, b);
    if (b.position_count + from.count > kChunkSize) break;
    // runs of one cell that the sort brought together become one
    const bool goes_on = b.run_count > 0 && b.runs[b.run_count - 1].first_slot == from.first_slot &&
                         b.runs[b.run_count - 1].count + from.count <= kMaxRun;
    if (!goes_on) {
      const CellPlace place{from.first_slot, from.edge, from.cell_log2, {}};
      b.runs[b.run_count++] = {static_cast<uint32_t>(b.position_count), 0, from.first_slot, 0, 0, 0, grid.tree.cornersOf(place)};
    }
    b.runs[b.run_count - 1].count += from.count;
    // positions of a run side by side, so that kernels load them as vectors
    for (uint32_t i = from.first; i < from.first + from.count; ++i, ++b.position_count) {
      std::memcpy(b.from_low + 4 * b.position_count, b.block_from_low + 4 * size_t{i}, 4 * sizeof(float));
      b.order[b.position_count] = i;
    }
  }
  // sorted by function each theta is read once a chunk; keys from the least on need fewer passes
  for (size_t r = 0; r < b.run_count; ++r) addItems(grid, b.runs[r], b);
  uint32_t least = UINT32_MAX, most = 0;
  for (size_t i = 0; i < b.item_count; ++i) {
    least = std::min(least, b.items[i].function);
    most = std::max(most, b.items[i].function);
  }
  b.sorted_items = sortByKey(b.items.data(), b.spare_items.data(), b.item_count, b.item_count > 0 ? most - least : 0,
                             [least](const RunItem& item) { return item.function - least; });
  return next;
}

void lookUpBlock(const LightGrid& grid, const BatchSlice& slice, LookUpScratch::Buffers& b) {
  findRuns(grid, slice, b);
  for (size_t next = 0; next < b.list_run_count;) {
    next = fillChunk(grid, slice, next, b);
    HWY_DYNAMIC_DISPATCH(lightChunk)(grid, slice, b);
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
