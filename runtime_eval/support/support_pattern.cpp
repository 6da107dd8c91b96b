#include "runtime_eval/support/support_pattern.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

// Coordinates are odd multiples of 2^-16: lattice value u in {1, 3, … 65535}.
constexpr int kLattice = 65536;
constexpr int kCandidateCount = 96;
constexpr uint64_t kPatternSeed = 2024;

using LatticePoint = std::array<int64_t, 3>;

LatticePoint randomLatticePoint(Random& random) {
  LatticePoint point;
  for (int64_t& u : point) u = 2 * int64_t{random.below(kLattice / 2)} + 1;
  return point;
}

// Squared distance to the nearest chosen point, mirror images included. Within an octant the images of other points are never
// nearer than the points themselves, so only the candidate's own images count; the outer border is treated as a mirror too,
// or the points would crowd there.
int64_t squaredClearance(const LatticePoint& candidate, const std::vector<LatticePoint>& chosen) {
  int64_t clearance = INT64_MAX;
  for (const int64_t u : candidate) {
    const int64_t to_image = 2 * std::min(u, kLattice - u);
    clearance = std::min(clearance, to_image * to_image);
  }
  for (const LatticePoint& other : chosen) {
    const int64_t dx = candidate[0] - other[0], dy = candidate[1] - other[1], dz = candidate[2] - other[2];
    clearance = std::min(clearance, dx * dx + dy * dy + dz * dz);
  }
  return clearance;
}

// Mitchell's best candidate (1991): of some random points the one that is farthest from all before it.
std::vector<LatticePoint> wellSpreadOctant() {
  Random random(kPatternSeed);
  std::vector<LatticePoint> chosen;
  chosen.reserve(kOctantPointCount);
  while (chosen.size() < kOctantPointCount) {
    LatticePoint best{};
    int64_t best_clearance = -1;
    for (int c = 0; c < kCandidateCount; ++c) {
      const LatticePoint candidate = randomLatticePoint(random);
      const int64_t clearance = squaredClearance(candidate, chosen);
      if (clearance > best_clearance) best = candidate, best_clearance = clearance;
    }
    chosen.push_back(best);
  }
  return chosen;
}

uint64_t mortonCode(const LatticePoint& point) {
  uint64_t code = 0;
  for (int bit = 15; bit >= 0; --bit) {
    for (const int64_t u : point) code = (code << 1) | ((u >> bit) & 1);
  }
  return code;
}

SupportPattern makePattern() {
  std::vector<LatticePoint> octant = wellSpreadOctant();
  std::sort(octant.begin(), octant.end(),
            [](const LatticePoint& a, const LatticePoint& b) { return mortonCode(a) < mortonCode(b); });
  SupportPattern pattern;
  pattern.points.reserve(kSupportPointCount);
  for (int mirror = 0; mirror < kMirrorCount; ++mirror) {
    for (const LatticePoint& lattice : octant) {
      LocalPoint point;
      for (int axis = 0; axis < 3; ++axis) {
        const float coordinate = static_cast<float>(lattice[axis]) / kLattice;
        point[axis] = (mirror >> axis) & 1 ? -coordinate : coordinate;
      }
      pattern.points.push_back(point);
    }
  }
  pattern.hash = hashPoints(pattern.points);
  return pattern;
}

}  // namespace

float tent(const LocalPoint& point) {
  float product = 1.0f;
  for (const float coordinate : point) product *= std::max(0.0f, 1.0f - std::fabs(coordinate));
  return product;
}

const SupportPattern& supportPattern() {
  static const SupportPattern pattern = makePattern();
  return pattern;
}

std::vector<LocalPoint> testPoints(int count) {
  // 2^32 divided by the powers of the root of g^4 = g + 1
  constexpr uint32_t kStep[3] = {3518319155u, 2882110345u, 2360945575u};
  std::vector<LocalPoint> points(count);
  for (int n = 0; n < count; ++n) {
    for (int axis = 0; axis < 3; ++axis) {
      const uint32_t fraction = 0x80000000u + static_cast<uint32_t>(n + 1) * kStep[axis];
      points[n][axis] = static_cast<float>((fraction >> 9) * 2 + 1) * 0x1p-23f - 1.0f;
    }
  }
  return points;
}

uint64_t hashPoints(const std::vector<LocalPoint>& points) {
  uint64_t hash = 0xcbf29ce484222325u;
  for (const LocalPoint& point : points) {
    for (const float coordinate : point) {
      uint32_t bits;
      std::memcpy(&bits, &coordinate, sizeof bits);
      for (int shift = 0; shift < 32; shift += 8) hash = (hash ^ ((bits >> shift) & 255)) * 0x100000001b3u;
    }
  }
  return hash;
}

PointSet makePointSet(const std::vector<LocalPoint>& points) {
  PointSet set;
  set.count = static_cast<int>(points.size());
  set.padded_count = (set.count + 15) / 16 * 16;
  for (AlignedFloats* values : {&set.x, &set.y, &set.z, &set.tent}) values->resize(set.padded_count);
  for (int i = 0; i < set.padded_count; ++i) {
    const LocalPoint& point = points[i < set.count ? i : 0];
    set.x[i] = point[0];
    set.y[i] = point[1];
    set.z[i] = point[2];
    set.tent[i] = tent(point);
  }
  return set;
}

int stratifiedPatternIndex(int place) {
  const int k = place / kStratumPointCount, s = place / kMinibatchPointCount % 4, m = place / 32 % kMirrorCount, t = place % 32;
  return m * kOctantPointCount + 32 * t + 8 * s + k;
}

const PointSet& stratifiedSupportPoints() {
  static const PointSet set = [] {
    const std::vector<LocalPoint>& points = supportPattern().points;
    std::vector<LocalPoint> stratified;
    stratified.reserve(points.size());
    for (int place = 0; place < kSupportPointCount; ++place) stratified.push_back(points[stratifiedPatternIndex(place)]);
    return makePointSet(stratified);
  }();
  return set;
}

}  // namespace nlg
