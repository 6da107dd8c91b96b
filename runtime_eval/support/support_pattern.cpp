#include "runtime_eval/support/point_order.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

// Coordinates are odd multiples of 2^-16: lattice value u in {1, 3, … 65535}.
constexpr int kLattice = 65536;
constexpr uint64_t kPatternSeed = 2024;

// The octant is 128 points of [0, 1/2]³ and their images. On each axis every point has a rank of its own, r in 0 … 127, and stands
// within a quarter of a step of (2 r + 1) / 512: no wall along the lattice passes between the probe and all points. Ranks that were
// exact would tie distances, and the links between points with them.
constexpr int kRankCount = 128;
constexpr int kRankStep = kLattice / 2 / kRankCount;
// The octant in 4³ cells of 16 points each. Cells that are images of each other hold images of the same points.
constexpr int kRunPoints = 16;
struct PointRun {
  uint8_t cell;     // Morton index, x first
  uint64_t points;  // four bits a point, the first lowest: which of the cell's
};

// Ranks by cell of [0, 1/2]³, bits of the cell as of a mirror, and the order of the octant's points. Both were found once by simulated
// annealing of swaps: of ranks, for repulsion over several distances and the wrap-around discrepancy of the octant; of points inside a
// cell and of neighbouring cells, for the same of strata and of minibatches (docs/lab/weighting_functions.md).
// clang-format off
constexpr uint8_t kBasePoints[kRankCount][3] = {
    {21, 52, 36}, {33, 21, 29}, {46, 8, 57}, {53, 3, 14}, {6, 32, 34}, {11, 11, 12}, {15, 45, 9}, {17, 1, 41}, {35, 26, 3},
    {63, 59, 22}, {3, 58, 59}, {43, 44, 25}, {30, 55, 62}, {57, 17, 37}, {24, 30, 55}, {51, 40, 49}, {84, 4, 46}, {105, 41, 24},
    {126, 24, 17}, {113, 56, 6}, {74, 53, 51}, {108, 6, 28}, {98, 61, 39}, {80, 13, 19}, {119, 15, 53}, {76, 36, 32}, {121, 46, 47},
    {85, 50, 11}, {70, 22, 61}, {100, 18, 1}, {64, 33, 7}, {96, 29, 44}, {31, 127, 18}, {39, 64, 5}, {5, 112, 21}, {48, 104, 8},
    {61, 99, 60}, {9, 84, 45}, {37, 90, 50}, {45, 66, 43}, {2, 69, 16}, {25, 77, 26}, {52, 85, 23}, {19, 93, 0}, {28, 101, 31},
    {41, 119, 54}, {58, 111, 38}, {13, 116, 48}, {124, 110, 42}, {78, 98, 27}, {66, 121, 15}, {95, 123, 33}, {90, 108, 4}, {111, 89, 10},
    {69, 78, 40}, {104, 94, 35}, {109, 120, 63}, {72, 81, 2}, {122, 71, 30}, {115, 87, 58}, {86, 106, 52}, {118, 115, 13}, {92, 74, 20},
    {88, 82, 56}, {4, 42, 112}, {8, 14, 98}, {36, 57, 87}, {14, 38, 82}, {59, 49, 74}, {32, 51, 121}, {10, 63, 91}, {60, 25, 92},
    {54, 47, 104}, {26, 7, 78}, {20, 16, 123}, {29, 34, 100}, {42, 28, 75}, {0, 19, 65}, {49, 23, 120}, {40, 5, 103}, {110, 2, 110},
    {81, 43, 89}, {77, 37, 116}, {106, 48, 94}, {87, 60, 108}, {67, 0, 84}, {117, 12, 83}, {73, 9, 114}, {114, 35, 72}, {89, 39, 68},
    {112, 54, 119}, {103, 62, 64}, {101, 27, 126}, {91, 20, 96}, {94, 10, 70}, {123, 31, 105}, {55, 73, 66}, {23, 79, 69}, {44, 95, 115},
    {16, 124, 80}, {50, 114, 88}, {27, 122, 109}, {22, 88, 95}, {1, 107, 102}, {18, 102, 125}, {62, 67, 127}, {7, 97, 71}, {47, 86, 85},
    {12, 75, 117}, {38, 72, 107}, {56, 118, 113}, {34, 105, 73}, {68, 91, 106}, {120, 80, 111}, {65, 70, 97}, {102, 76, 90}, {99, 103, 76},
    {107, 126, 99}, {125, 100, 86}, {93, 83, 124}, {83, 113, 122}, {116, 109, 118}, {127, 65, 79}, {79, 117, 93}, {71, 125, 67}, {82, 68, 77},
    {97, 96, 101}, {75, 92, 81},
};
constexpr PointRun kOctantOrder[kOctantPointCount / kRunPoints] = {
    {0, 0x327fd46a08b5ec91}, {1, 0x38f165aeb40297dc}, {2, 0xf8d63e71b590ca24}, {3, 0x75b4e10623fadc98},
    {4, 0x4ad3e920f18c657b}, {5, 0x194c03e867b5adf2}, {7, 0x45f8be102da7963c}, {6, 0x8509ecda263b17f4},
    {8, 0x7240d9ba1f68ce53}, {9, 0x215bfd406ace9783}, {11, 0x74fc619350ed82ab}, {10, 0x16d8a350429e7bfc},
    {12, 0xb6ced453a17829f0}, {13, 0x2c9ae04fbd758316}, {15, 0x5c72a08d1e9436bf}, {14, 0x0754f128369dcaeb},
    {17, 0x3f4165792b8c0dea}, {16, 0xc784b062d91af53e}, {18, 0xb945120cde3f76a8}, {19, 0x41698cfbdea57230},
    {20, 0xe3ba74c5d2f18690}, {21, 0x7c103fbed925648a}, {23, 0xf72ab89ec41360d5}, {22, 0x12c983d40fa6be75},
    {24, 0x7ac2819f0e56b43d}, {25, 0x6a417358cfb20de9}, {26, 0xa527f0e39d8c61b4}, {27, 0x158ac4bf90d763e2},
    {28, 0xebdf52c4893a0761}, {29, 0x4aec08d2b539f167}, {31, 0xce2a986035fd74b1}, {30, 0x735fd1b68e09c2a4},
    {33, 0xef94317652a0db8c}, {32, 0xd5b82a6c93e4f107}, {35, 0x1f7ad46b2e508c93}, {34, 0x0c5e416da9f3b278},
    {36, 0x8d9103cbea465f72}, {37, 0xa6cd5b1027fe4983}, {39, 0x8c17b6af3420d9e5}, {38, 0x87c36dba42e91f05},
    {41, 0xd980325467cbafe1}, {40, 0x289d7c140afb536e}, {43, 0x67e5234a8d1b9fc0}, {42, 0x64ac30598d2e17bf},
    {45, 0xb6087a9d2e3415fc}, {44, 0x4ea601c9bfd73852}, {47, 0x0235b7f9e6da4c81}, {46, 0x65e93082cfad471b},
    {48, 0x7f98c513be402da6}, {49, 0xb842c9ad03e671f5}, {51, 0x7036c42a98deb15f}, {50, 0x0e9257863a1d4cfb},
    {53, 0x0153e846d9ab72fc}, {52, 0xa46f59db3c08271e}, {54, 0xa8792e1d64f0b5c3}, {55, 0xb2ac4fe70938156d},
    {56, 0xd1b8ae325f69407c}, {57, 0xe0d74a9832c61b5f}, {58, 0xa165970c43b2f8ed}, {59, 0xf0471d9e863c5ba2},
    {60, 0x4d2bcf07a815936e}, {61, 0xdbf0984615ac7e23}, {63, 0x4fabc9563217e8d0}, {62, 0x6372e401c89abdf5},
};
// clang-format on

// Which two points of each cell of [0, 1/2]³ are sample points, with all their images: found by annealing, for repulsion and for even ranks.
constexpr int kSamplesOfBase[kMirrorCount][2] = {{1, 10}, {0, 1}, {1, 12}, {3, 14}, {4, 11}, {10, 13}, {4, 6}, {0, 6}};

// A cell in the outer half of an axis is the mirror image of one in the inner half.
struct CellImage {
  int base_cell = 0;
  bool is_image[3];
};
CellImage cellImage(const PointRun& run) {
  CellImage image;
  for (int axis = 0; axis < 3; ++axis) {
    const int outer = run.cell >> (5 - axis) & 1, inner = run.cell >> (2 - axis) & 1;
    image.is_image[axis] = outer == 1;
    image.base_cell |= (outer ^ inner) << axis;
  }
  return image;
}
// Which of its cell's points the k-th of a run is.
int basePoint(const PointRun& run, int k) { return static_cast<int>(run.points >> (4 * k) & 15); }

using LatticePoint = std::array<int, 3>;

std::vector<LatticePoint> basePoints() {
  Random random(kPatternSeed);
  std::vector<LatticePoint> points;
  for (const auto& ranks : kBasePoints) {
    LatticePoint point;
    for (int axis = 0; axis < 3; ++axis) {
      const int odd = 2 * static_cast<int>(random.below(kRankStep / 4)) + 1 - kRankStep / 4;
      point[axis] = ranks[axis] * kRankStep + kRankStep / 2 + odd;
    }
    points.push_back(point);
  }
  return points;
}

std::vector<LatticePoint> octantPoints() {
  const std::vector<LatticePoint> base = basePoints();
  std::vector<LatticePoint> octant;
  for (const PointRun& run : kOctantOrder) {
    const CellImage image = cellImage(run);
    for (int k = 0; k < kRunPoints; ++k) {
      LatticePoint point = base[image.base_cell * kRunPoints + basePoint(run, k)];
      for (int axis = 0; axis < 3; ++axis) {
        if (image.is_image[axis]) point[axis] = kLattice - point[axis];
      }
      octant.push_back(point);
    }
  }
  return octant;
}

SupportPattern makePattern() {
  const std::vector<LatticePoint> octant = octantPoints();
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

const std::array<uint16_t, kOctantSampleCount>& octantSamples() {
  static const std::array<uint16_t, kOctantSampleCount> samples = [] {
    std::array<uint16_t, kOctantSampleCount> points{};
    size_t count = 0;
    for (size_t run = 0; run < std::size(kOctantOrder); ++run) {
      const int* chosen = kSamplesOfBase[cellImage(kOctantOrder[run]).base_cell];
      for (int k = 0; k < kRunPoints; ++k) {
        const int point = basePoint(kOctantOrder[run], k);
        if (point == chosen[0] || point == chosen[1]) points[count++] = static_cast<uint16_t>(run * kRunPoints + k);
      }
    }
    return points;
  }();
  return samples;
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

PointSet makePointSet(const LocalPoint* points, size_t count) {
  PointSet set;
  set.count = static_cast<int>(count);
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
