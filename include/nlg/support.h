// Support points and weighting functions: what an engine samples, and what everything else here takes.
//
// A weighting function phi says how much a probe counts at a point of its support, the cube of two probe spacings around it:
// phi = tent * visibility, in [0, 1]. It is sampled at P = 8192 points, the same for every probe.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace nlg {

inline constexpr int kOctantPointCount = 1024;
inline constexpr int kMirrorCount = 8;
inline constexpr int kSupportPointCount = kOctantPointCount * kMirrorCount;  // P
inline constexpr int kValidityByteCount = kSupportPointCount / 8;

// A point in local coordinates, (-1, 1)³; one unit is one probe spacing.
using LocalPoint = std::array<float, 3>;

// The bare tent Π max(0, 1 - |x_i|): the weighting function of a probe in free space.
float tent(const LocalPoint& point);

// 1024 points in the positive octant, and their 8 mirror images. Point i of mirror m has index m * 1024 + i; bits 0, 1, 2 of m say that
// x, y, z are negative. Mirroring a function is therefore a permutation of whole runs of 1024 values (index XOR).
//
// The octant is closed under x → 1 − x on each axis: the eight probes of a lattice cell sample it at the same 1024 points. Each axis takes
// 256 evenly spaced values, so that points lie on both sides of any wall along an axis.
//
// Inside an octant runs of 16 points fill cells of a quarter of a spacing, along a Morton curve: neighbours in memory are neighbours
// in space. Every eighth point (i % 8 == k) is a stratum of 1024 well spread points, two of each cell and mirror; every 32nd a quarter of it.
struct SupportPattern {
  std::vector<LocalPoint> points;  // P, exact multiples of 2^-16, none on a mirror plane or on the border
  uint64_t hash = 0;               // of the points and their order; every file that depends on them holds it
};

// Integer arithmetic alone: the same bits on every machine.
const SupportPattern& supportPattern();

// Points that no fit samples, for judging fits: a low-discrepancy sequence (Roberts 2018, R3) over the whole support.
// count   >= 0; the first points of a longer set are the shorter set
std::vector<LocalPoint> testPoints(int count);

// A view of one sampled function. All pointers must outlive it.
struct StoredFunction {
  const uint8_t* phi = nullptr;       // P, round(255 phi), in the order of supportPattern(); 0 where a point is not valid
  const uint8_t* validity = nullptr;  // P / 8, bit i of byte b is point 8 b + i: the point lies in air
  const uint8_t* seen = nullptr;      // likewise: the probe sees the point; null where it is not needed
  // P, round(255 min(1, S)), S the sum of the functions of all probes of the cell at the point: what the loss weighs lit points by. Null: S
  // is taken as 1, as if other probes saw whatever this one sees; points that only this probe sees may then turn black.
  const uint8_t* blend_sum = nullptr;

  bool isValid(size_t point) const { return validity[point / 8] >> (point % 8) & 1; }
  bool isSeen(size_t point) const { return seen[point / 8] >> (point % 8) & 1; }
  uint8_t blendSum(size_t point) const { return blend_sum == nullptr ? 255 : blend_sum[point]; }
};

// How the loss weighs residuals (docs/theory/math.md §5). CheckOptions (check.h) holds the defaults.
struct LossOptions {
  double dark_weight;  // >= 1: weight of points whose phi is 0 inside the tent, where a residual is a leak
  double blend_floor;  // (0, 1]: a lit point weighs 1 / max(blend_floor, S)²
};

}  // namespace nlg
