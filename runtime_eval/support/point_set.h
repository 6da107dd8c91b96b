// Points in the layout of vector kernels, and the strata of the support pattern.
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

}  // namespace nlg
