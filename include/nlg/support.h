// Support points, and weighting functions sampled at them: the input of generator, check and policy.
//
// A weighting function phi says how much a probe counts at a point of its support, the cube of two probe spacings around it:
// the tent where the probe sees the point, else 0 or what diffuses there, in [0, 1]. It is sampled at P = 8192 points, the same for
// every probe.
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

// The support points: 1024 in the positive octant, and their 8 mirror images. Point i of mirror m has index m * 1024 + i; bits 0,
// 1, 2 of m say that x, y, z are negative. Mirroring a function thus permutes whole runs of 1024 values (index XOR).
//
// The octant is closed under x → 1 − x on each axis: the eight probes of a lattice cell sample it at the same 1024 points. Each axis takes
// 256 values, evenly spaced but for a quarter of a step, so that points lie on both sides of any wall along an axis.
//
// Inside an octant runs of 16 points fill cells of a quarter of a spacing, nearly along a Morton curve: neighbours in memory are neighbours
// in space. The points with i % 8 == k are a stratum of 1024 well-spread points, two in each cell and mirror.
struct SupportPattern {
  std::vector<LocalPoint> points;  // P, exact multiples of 2^-16, none on a mirror plane or on the border
  uint64_t hash = 0;               // of the points and their order; stored in every file that depends on them
};

// Returns the support points, the same bits on every machine. The first call computes them; safe from any thread.
const SupportPattern& supportPattern();

// Returns points that no fit samples, to judge fits by: a low-discrepancy sequence (Roberts 2018, R3) over the whole support.
// count   >= 0, as 2048; a longer set begins with the shorter ones
std::vector<LocalPoint> testPoints(int count);

// A view of one sampled weighting function. It owns nothing.
struct StoredFunction {
  const uint8_t* phi = nullptr;       // P, round(255 phi), in the order of supportPattern(); 0 where a point is not valid
  const uint8_t* validity = nullptr;  // P / 8, bit i of byte b is point 8 b + i: the point lies in air
  const uint8_t* seen = nullptr;      // likewise: the probe sees the point; null where it is not needed
  // P, round(255 min(1, S)); S is the sum, at the point, of the functions of all probes of its cell. The loss weighs lit points
  // by it. Null: S is taken as 1, as if other probes saw all that this one sees; points that only this probe sees may then turn
  // black.
  const uint8_t* blend_sum = nullptr;

  bool isValid(size_t point) const { return validity[point / 8] >> (point % 8) & 1; }
  uint8_t blendSum(size_t point) const { return blend_sum == nullptr ? 255 : blend_sum[point]; }
};

// The sample points: an eighth of the support points, two in each quarter cell. They are what a generator of samples reads of a function,
// and all that has to be traced where no function is wanted. They are closed under x → 1 − x, too: the eight probes of a lattice cell share
// them.
inline constexpr int kSamplePointCount = 1024;
inline constexpr int kOctantSampleCount = kSamplePointCount / kMirrorCount;

// Returns the points of the first octant, rising: sample point m * 128 + t is support point m * 1024 + octantSamples()[t].
const std::array<uint16_t, kOctantSampleCount>& octantSamples();
// Returns the support point of a sample point.
inline size_t supportPointOf(int sample) {
  return static_cast<size_t>(sample / kOctantSampleCount) * kOctantPointCount + octantSamples()[sample % kOctantSampleCount];
}

// A view of what a probe sees at the sample points: bit i of byte b is sample point 8 b + i.
struct VisibilitySamples {
  const uint8_t* seen = nullptr;      // kSamplePointCount / 8: the segment from the probe to the point meets no triangle
  const uint8_t* validity = nullptr;  // likewise: the point lies in air; every seen point does
};

// Weights of residuals in the loss (docs/theory/math.md §4). CheckOptions (check.h) holds the defaults.
struct LossOptions {
  double dark_weight;  // >= 1: weight of points whose phi is 0 inside the tent, where a residual is a leak
  double blend_floor;  // (0, 1]: a lit point weighs 1 / max(blend_floor, S)²
};

}  // namespace nlg
