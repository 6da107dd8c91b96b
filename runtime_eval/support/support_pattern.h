// The support points: one fixed pattern of P = 8192 points in local coordinates (-1,1)³, the same for every probe.
//
// 1024 points in the positive octant, and their 8 mirror images. Point i of mirror m has index m * 1024 + i; bit 0, 1, 2 of m
// says that x, y, z is negative. Mirroring a function is therefore a permutation of whole runs of 1024 values (index XOR), and
// the Walsh–Hadamard transform over m splits any function into 8 parity classes (docs/theory/math.md §2).
//
// The octant is closed under x → 1 − x on each axis: seen from any probe of a cell of the lattice, the points in that cell are the
// same 1024 places. On each axis they take 256 evenly spaced values, so that points lie on both sides of any wall along an axis.
//
// Inside an octant runs of 16 points fill cells of a quarter of a spacing, along a Morton curve: neighbours in memory are neighbours
// in space. Every eighth point is again well spread: stratum k holds the points with i % 8 == k of all mirrors, 1024 points, two of
// each cell and mirror. So is every 32nd: a quarter of a stratum, 256 points, is what one minibatch reads.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "runtime_eval/simd/aligned.h"

namespace nlg {

inline constexpr int kOctantPointCount = 1024;
inline constexpr int kMirrorCount = 8;
inline constexpr int kSupportPointCount = kOctantPointCount * kMirrorCount;  // P
inline constexpr int kStratumCount = 8;
inline constexpr int kStratumPointCount = kSupportPointCount / kStratumCount;
inline constexpr int kMinibatchPointCount = kStratumPointCount / 4;
inline constexpr int kValidityByteCount = kSupportPointCount / 8;

// A point in local coordinates; one unit is one probe spacing.
using LocalPoint = std::array<float, 3>;

// The bare tent Π max(0, 1 - |x_i|).
float tent(const LocalPoint& point);

struct SupportPattern {
  std::vector<LocalPoint> points;  // P, exact multiples of 2^-16, none on a mirror plane or on the border
  uint64_t hash = 0;               // of the points and their order; travels with every artefact
};

// The pattern: integer arithmetic alone, the same bits on every machine.
const SupportPattern& supportPattern();

// Points that no fit sees, for judging fits: a low-discrepancy sequence (Roberts 2018, R3) over the whole support.
// count   >= 0; the first points of a longer set are the shorter set
std::vector<LocalPoint> testPoints(int count);

// Hash of any list of points: FNV-1a over their bits.
uint64_t hashPoints(const std::vector<LocalPoint>& points);

// Points in structure-of-arrays form for the vector kernels, padded to a multiple of 16 by copies of the first point.
struct PointSet {
  int count = 0;
  int padded_count = 0;
  AlignedFloats x, y, z, tent;  // padded_count each
};
PointSet makePointSet(const std::vector<LocalPoint>& points);

// The support points in stratum order: stratum k occupies [k * 1024, (k + 1) * 1024), inside it quarter after quarter, a quarter
// mirror-major. Stratum order index k * 1024 + s * 256 + m * 32 + t is pattern index m * 1024 + 32 t + 8 s + k.
int stratifiedPatternIndex(int place);
const PointSet& stratifiedSupportPoints();

}  // namespace nlg
