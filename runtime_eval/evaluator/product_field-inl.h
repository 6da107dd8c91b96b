// Evaluates product fields at vectors of points of one cell, for any Highway target. Included once per target; see Highway's
// quick reference on "-inl.h". docs/theory/representations.md §8 has the formulas.
#if defined(NLG_PRODUCT_FIELD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef NLG_PRODUCT_FIELD_INL_H_
#undef NLG_PRODUCT_FIELD_INL_H_
#else
#define NLG_PRODUCT_FIELD_INL_H_
#endif

#include <hwy/highway.h>

#include "runtime_eval/evaluator/elementary-inl.h"
#include "runtime_eval/support/point_order.h"

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Two nodes that are neighbours along x: A, B, A, B.
#if HWY_TARGET == HWY_SCALAR
// one lane a vector, no shuffles
struct Nodes {
  float value[4];
};

template <class Operation>
HWY_INLINE Nodes eachNode(const Operation& operation) {
  return {{operation(0), operation(1), operation(2), operation(3)}};
}
HWY_INLINE Nodes loadNodes(const float* from) { return {{from[0], from[1], from[2], from[3]}}; }
HWY_INLINE void storeNodes(Nodes nodes, float* to) {
  for (int i = 0; i < 4; ++i) to[i] = nodes.value[i];
}
HWY_INLINE Nodes add(Nodes a, Nodes b) {
  return eachNode([&](int i) { return a.value[i] + b.value[i]; });
}
HWY_INLINE Nodes subtract(Nodes a, Nodes b) {
  return eachNode([&](int i) { return a.value[i] - b.value[i]; });
}
HWY_INLINE Nodes scale(float factor, Nodes a) {
  return eachNode([&](int i) { return factor * a.value[i]; });
}
// factor * a + b
HWY_INLINE Nodes multiplyAdd(float factor, Nodes a, Nodes b) {
  return eachNode([&](int i) { return factor * a.value[i] + b.value[i]; });
}
// (a0, b0, a1, b1) → (a0, b0, a0, b0) and (a1, b1, a1, b1)
HWY_INLINE Nodes lowTwice(Nodes a) {
  return eachNode([&](int i) { return a.value[i % 2]; });
}
HWY_INLINE Nodes highTwice(Nodes a) {
  return eachNode([&](int i) { return a.value[2 + i % 2]; });
}
HWY_INLINE Nodes negateLow(Nodes a) { return {{-a.value[0], -a.value[1], a.value[2], a.value[3]}}; }
HWY_INLINE Nodes negateHigh(Nodes a) { return {{a.value[0], a.value[1], -a.value[2], -a.value[3]}}; }
// Sums of the lanes of four vectors, side by side.
HWY_INLINE Nodes sumsOfLanes(FloatTag, Floats s0, Floats s1, Floats s2, Floats s3) {
  return {{hn::GetLane(s0), hn::GetLane(s1), hn::GetLane(s2), hn::GetLane(s3)}};
}
#else
using NodeTag = hn::FixedTag<float, 4>;
using Nodes = hn::Vec<NodeTag>;

HWY_INLINE Nodes loadNodes(const float* from) { return hn::LoadU(NodeTag(), from); }
HWY_INLINE void storeNodes(Nodes nodes, float* to) { hn::StoreU(nodes, NodeTag(), to); }
HWY_INLINE Nodes add(Nodes a, Nodes b) { return hn::Add(a, b); }
HWY_INLINE Nodes subtract(Nodes a, Nodes b) { return hn::Sub(a, b); }
HWY_INLINE Nodes scale(float factor, Nodes a) { return hn::Mul(hn::Set(NodeTag(), factor), a); }
// factor * a + b
HWY_INLINE Nodes multiplyAdd(float factor, Nodes a, Nodes b) { return hn::MulAdd(hn::Set(NodeTag(), factor), a, b); }
// (a0, b0, a1, b1) → (a0, b0, a0, b0) and (a1, b1, a1, b1)
HWY_INLINE Nodes lowTwice(Nodes a) { return hn::ConcatLowerLower(NodeTag(), a, a); }
HWY_INLINE Nodes highTwice(Nodes a) { return hn::ConcatUpperUpper(NodeTag(), a, a); }
HWY_INLINE Nodes negateLow(Nodes a) {
  alignas(16) constexpr float kSign[4] = {-1.0f, -1.0f, 1.0f, 1.0f};
  return hn::Mul(a, hn::Load(NodeTag(), kSign));
}
HWY_INLINE Nodes negateHigh(Nodes a) {
  alignas(16) constexpr float kSign[4] = {1.0f, 1.0f, -1.0f, -1.0f};
  return hn::Mul(a, hn::Load(NodeTag(), kSign));
}
// Sums of the lanes of four vectors, side by side.
HWY_INLINE Nodes sumsOfLanes(FloatTag d, Floats s0, Floats s1, Floats s2, Floats s3) {
  const hn::RepartitionToWide<FloatTag> pairs;
  const auto s01 = hn::BitCast(pairs, hn::Add(hn::InterleaveLower(d, s0, s1), hn::InterleaveUpper(d, s0, s1)));
  const auto s23 = hn::BitCast(pairs, hn::Add(hn::InterleaveLower(d, s2, s3), hn::InterleaveUpper(d, s2, s3)));
  // every block of four lanes now adds up to its share of the four sums
  alignas(64) float lanes[16];
  hn::Store(hn::Add(hn::BitCast(d, hn::InterleaveLower(pairs, s01, s23)), hn::BitCast(d, hn::InterleaveUpper(pairs, s01, s23))),
            d, lanes);
  Nodes sum = loadNodes(lanes);
  for (size_t i = 4; i < hn::Lanes(d); i += 4) sum = add(sum, loadNodes(lanes + i));
  return sum;
}
#endif

// Where a cell of the grid lies in theta and in space.
struct Cell {
  int first_node;  // node at its low corner
  float shift[3];  // centred coordinate = (r - 1) * position + shift: -1 … 1 across the cell, exact for support points
};

HWY_INLINE Cell cellAt(int resolution, int cell) {
  const int cells = resolution - 1;
  const int x = cell % cells, y = cell / cells % cells, z = cell / (cells * cells);
  const auto shift = [cells](int i) { return static_cast<float>(cells - 1 - 2 * i); };
  return {x + resolution * (y + resolution * z), {shift(x), shift(y), shift(z)}};
}

// Centred coordinates of one vector of points in their cell.
struct CellPosition {
  Floats x, y, z;
};

HWY_INLINE CellPosition cellPosition(FloatTag d, const PointOrder& order, const Cell& cell, Floats scale, int place) {
  return {hn::MulAdd(scale, hn::Load(d, &order.points.x[place]), hn::Set(d, cell.shift[0])),
          hn::MulAdd(scale, hn::Load(d, &order.points.y[place]), hn::Set(d, cell.shift[1])),
          hn::MulAdd(scale, hn::Load(d, &order.points.z[place]), hn::Set(d, cell.shift[2]))};
}

// A and B as polynomials of the centred coordinates: by power of y and z (0: 1, 1: y, 2: z, 3: y z) the coefficients of
// A, B, A x, B x.
struct alignas(64) CellPolynomials {
  float coefficient[4][4];
};

// Replaces (a, b) by (a + b, b - a): values at -1 and 1 by twice the coefficients of 1 and x.
HWY_INLINE void sumAndDifference(Nodes& low, Nodes& high) {
  const Nodes sum = add(low, high);
  high = subtract(high, low);
  low = sum;
}

// The same along x: (A0, B0, A1, B1) → (A1 + A0, B1 + B0, A1 - A0, B1 - B0).
HWY_INLINE Nodes sumAndDifferenceAlongX(Nodes pair) { return add(highTwice(pair), negateHigh(lowTwice(pair))); }

HWY_INLINE void loadCell(int resolution, const Cell& cell, const float* HWY_RESTRICT theta, CellPolynomials& polynomials) {
  const float* node = theta + 2 * cell.first_node;
  const int y = 2 * resolution, z = 2 * resolution * resolution;
  // eighths first: sums of eight large nodes stay finite
  const auto eighths = [](const float* from) { return scale(0.125f, loadNodes(from)); };
  Nodes corner[4] = {eighths(node), eighths(node + y), eighths(node + z), eighths(node + z + y)};
  sumAndDifference(corner[0], corner[1]);
  sumAndDifference(corner[2], corner[3]);
  sumAndDifference(corner[0], corner[2]);
  sumAndDifference(corner[1], corner[3]);
  for (int i = 0; i < 4; ++i) storeNodes(sumAndDifferenceAlongX(corner[i]), polynomials.coefficient[i]);
}

// The transpose of loadCell: sums over points of g times each monomial, in its layout, added to the gradient of the 8 nodes.
HWY_INLINE void addCellGradient(int resolution, const Cell& cell, const Nodes* sums, float* HWY_RESTRICT gradient) {
  const auto differenceAndSum = [](Nodes& low, Nodes& high) {
    const Nodes difference = subtract(low, high);
    high = add(low, high);
    low = difference;
  };
  Nodes corner[4];
  for (int i = 0; i < 4; ++i) corner[i] = add(lowTwice(sums[i]), negateLow(highTwice(sums[i])));
  differenceAndSum(corner[0], corner[1]);
  differenceAndSum(corner[2], corner[3]);
  differenceAndSum(corner[0], corner[2]);
  differenceAndSum(corner[1], corner[3]);
  float* node = gradient + 2 * cell.first_node;
  const int y = 2 * resolution, z = 2 * resolution * resolution, offset[4] = {0, y, z, z + y};
  for (int i = 0; i < 4; ++i) storeNodes(multiplyAdd(0.125f, corner[i], loadNodes(node + offset[i])), node + offset[i]);
}

// A (channel 0) or B (channel 1) at one vector of points.
template <int kChannel>
HWY_INLINE Floats cellValue(FloatTag d, const CellPolynomials& polynomials, const CellPosition& at) {
  const auto alongX = [&](int i) {
    return hn::MulAdd(hn::Set(d, polynomials.coefficient[i][2 + kChannel]), at.x,
                      hn::Set(d, polynomials.coefficient[i][kChannel]));
  };
  return hn::MulAdd(hn::MulAdd(alongX(3), at.y, alongX(2)), at.z, hn::MulAdd(alongX(1), at.y, alongX(0)));
}

// The field and its derivatives by A and B at one vector of points.
struct FieldPoint {
  Floats value, by_a, by_b;
};

HWY_INLINE FieldPoint fieldPoint(FloatTag d, const CellPolynomials& polynomials, const CellPosition& at) {
  const Floats a = cellValue<0>(d, polynomials, at);
  const Sigmoid s = sigmoid(d, cellValue<1>(d, polynomials, at));
  const Floats clamped = clampToUnit(d, a), value = hn::Mul(clamped, s.value);
  return {value, hn::IfThenElseZero(hn::Eq(a, clamped), s.value), hn::Mul(value, s.complement)};
}

// Sums over points of (by A, by B) times each monomial of a cell, in the layout of CellPolynomials.
struct MomentSums {
  Floats sum[16];
};

HWY_INLINE void clearMoments(FloatTag d, MomentSums& moments) {
#pragma GCC unroll 16
  for (Floats& sum : moments.sum) sum = hn::Zero(d);
}

HWY_INLINE void addMoments(const CellPosition& at, Floats by_a, Floats by_b, MomentSums& moments) {
  const Floats yz = hn::Mul(at.y, at.z);
  Floats* sum = moments.sum;
  const Floats a_x = hn::Mul(by_a, at.x), b_x = hn::Mul(by_b, at.x);
  sum[0] = hn::Add(sum[0], by_a);
  sum[1] = hn::Add(sum[1], by_b);
  sum[2] = hn::Add(sum[2], a_x);
  sum[3] = hn::Add(sum[3], b_x);
  const Floats power[3] = {at.y, at.z, yz};
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    sum[4 * i + 4] = hn::MulAdd(by_a, power[i], sum[4 * i + 4]);
    sum[4 * i + 5] = hn::MulAdd(by_b, power[i], sum[4 * i + 5]);
    sum[4 * i + 6] = hn::MulAdd(a_x, power[i], sum[4 * i + 6]);
    sum[4 * i + 7] = hn::MulAdd(b_x, power[i], sum[4 * i + 7]);
  }
}

HWY_INLINE void sumMoments(FloatTag d, const MomentSums& moments, Nodes* sums) {
  const Floats* s = moments.sum;
#pragma GCC unroll 4
  for (int i = 0; i < 4; ++i) sums[i] = sumsOfLanes(d, s[4 * i], s[4 * i + 1], s[4 * i + 2], s[4 * i + 3]);
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();
#endif
