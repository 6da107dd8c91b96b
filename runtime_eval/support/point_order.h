// The order of the support points in which a representation's kernels read them.
//
// Networks read strata (some hundred well-spread points will do for a minibatch); product fields read cell after cell of their
// grid, so that the 8 nodes of a cell are loaded once for all of its points.
#pragma once

#include <cstdint>
#include <vector>

#include "nlg/support.h"
#include "runtime_eval/simd/aligned.h"

namespace nlg {

inline constexpr int kStratumCount = 8;
inline constexpr int kStratumPointCount = kSupportPointCount / kStratumCount;
inline constexpr int kMinibatchPointCount = kStratumPointCount / 4;

// Hash of any list of points: FNV-1a over their bits.
uint64_t hashPoints(const std::vector<LocalPoint>& points);

// Points in structure-of-arrays form for the vector kernels, padded to a multiple of 16 by copies of the first point.
struct PointSet {
  int count = 0;
  int padded_count = 0;
  AlignedFloats x, y, z, tent;  // padded_count each
};
PointSet makePointSet(const LocalPoint* points, size_t count);
inline PointSet makePointSet(const std::vector<LocalPoint>& points) { return makePointSet(points.data(), points.size()); }

// The support points in stratum order: stratum k occupies [k * 1024, (k + 1) * 1024), inside it quarter after quarter, a quarter
// mirror-major. Stratum order index k * 1024 + s * 256 + m * 32 + t is pattern index m * 1024 + 32 t + 8 s + k.
int stratifiedPatternIndex(int place);
const PointSet& stratifiedSupportPoints();

// Runs of points are cut into whole groups of so many: the widest vectors.
inline constexpr int kPointGroup = 16;

struct PointOrder {
  PointSet points;                 // by place; padded_count places, of which `count` hold a point
  std::vector<int> pattern_index;  // by place: index into the support pattern, or -1 where a place only fills a group
  // Batch b holds places [batch_begin[b], batch_begin[b + 1]), multiples of kPointGroup.
  std::vector<int> batch_begin;
  int minibatch_places = 0;  // what one step of Adam reads: batches are made of so many places each
  // Cell orders only: cell c of (r - 1)³, x fastest, holds places [cell_begin[c], cell_begin[c + 1]), multiples of kPointGroup.
  std::vector<int> cell_begin;
  int resolution = 0;  // r of a cell order; 0: strata

  int batchCount() const { return static_cast<int>(batch_begin.size()) - 1; }
  int placeCount() const { return static_cast<int>(pattern_index.size()); }
};

// 8 batches of 1024 places, no place empty, minibatches of 256: stratifiedSupportPoints (point_order.h).
const PointOrder& stratumOrder();

// One batch: by cell of a grid of `resolution` nodes an axis over [-1, 1]³, pattern order inside a cell; each cell is filled up
// to whole groups with places that hold no point (position: the cell's centre). resolution   3, 5, 7 or 9
const PointOrder& cellOrder(int resolution);

}  // namespace nlg
