#include "runtime_eval/fit/normal_equations.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/fit/field_normal_equations.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include "runtime_eval/evaluator/product_field-inl.h"

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {

// So many places at a time: their rows (21 kB) stay in the level-1 cache.
constexpr int kChunk = 256;
// Products of two trilinear weights are Bernstein polynomials of degree 2 along each axis: (0: low², 1: low high, 2: high²).
// All products of a cell's Jacobian are sums over its points of one of a², a b, b² times one of 27 of them.
struct ChunkRows {
  alignas(64) float across[9][kChunk];  // by x + 3 y
  alignas(64) float along[9][kChunk];   // by z + 3 (0: a², 1: a b, 2: b²)
};
// Lanes of all sums, kSums x 16: row x + 3 y + 9 z + 27 (0: a², 1: a b, 2: b²), up to whole groups of four.
constexpr int kSums = 84;
struct ProductSums {
  alignas(64) float lanes[kSums][16];
};

// Low², low high, high² of a centred coordinate.
HWY_INLINE void bernstein(FloatTag d, Floats centred, Floats* terms) {
  const Floats half = hn::Set(d, 0.5f);
  const Floats high = hn::MulAdd(half, centred, half), low = hn::NegMulAdd(half, centred, half);
  terms[0] = hn::Mul(low, low);
  terms[1] = hn::Mul(low, high);
  terms[2] = hn::Mul(high, high);
}

HWY_INLINE void storeRows(FloatTag d, const CellPosition& at, Floats by_a, Floats by_b, int offset, ChunkRows& rows) {
  Floats x[3], y[3], z[3];
  bernstein(d, at.x, x);
  bernstein(d, at.y, y);
  bernstein(d, at.z, z);
  const Floats product[3] = {hn::Mul(by_a, by_a), hn::Mul(by_a, by_b), hn::Mul(by_b, by_b)};
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j) {
      hn::Store(hn::Mul(x[j], y[i]), d, &rows.across[j + 3 * i][offset]);
      hn::Store(hn::Mul(z[j], product[i]), d, &rows.along[j + 3 * i][offset]);
    }
  }
}

HWY_INLINE void addProducts(FloatTag d, const ChunkRows& rows, int count, ProductSums& sums) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  // the 27 polynomials separate into x y and z: 9 rows times 9 rows give all 81 sums
  for (int r = 0; r < 9; ++r) {
    Floats sum[9];
#pragma GCC unroll 9
    for (int k = 0; k < 9; ++k) sum[k] = hn::Load(d, sums.lanes[9 * r + k]);
    for (int i = 0; i < count; i += lanes) {
      const Floats along = hn::Load(d, &rows.along[r][i]);
#pragma GCC unroll 9
      for (int k = 0; k < 9; ++k) sum[k] = hn::MulAdd(along, hn::Load(d, &rows.across[k][i]), sum[k]);
    }
#pragma GCC unroll 9
    for (int k = 0; k < 9; ++k) hn::Store(sum[k], d, sums.lanes[9 * r + k]);
  }
}

// The 16 x 16 block of a cell's nodes into the lower triangle.
HWY_INLINE void addBlock(FloatTag d, int resolution, const Cell& cell, const ProductSums& sums, SymmetricBand& hessian) {
  alignas(16) float product[kSums];
  for (int i = 0; i < kSums; i += 4) {
    const auto lanes = [&](int k) { return hn::Load(d, sums.lanes[i + k]); };
    storeNodes(sumsOfLanes(d, lanes(0), lanes(1), lanes(2), lanes(3)), product + i);
  }
  // corner i of a cell and its part of the index of a product
  int node[8];
  constexpr int kPart[8] = {0, 1, 3, 4, 9, 10, 12, 13};
  for (int i = 0; i < 8; ++i) node[i] = 2 * (cell.first_node + (i & 1) + resolution * ((i >> 1 & 1) + resolution * (i >> 2)));
  for (int column = 0; column < 8; ++column) {
    for (int row = column; row < 8; ++row) {
      const float* at = product + kPart[row] + kPart[column];
      hessian.at(node[row], node[column]) += at[0];
      hessian.at(node[row] + 1, node[column]) += at[27];
      if (row > column) hessian.at(node[row], node[column] + 1) += at[27];
      hessian.at(node[row] + 1, node[column] + 1) += at[54];
    }
  }
}

// gradient   D floats, added to: J^T r
double addNormalEquations(const PointOrder& order, const WeightingFunction& function, const float* HWY_RESTRICT theta,
                          float* HWY_RESTRICT gradient, SymmetricBand& hessian) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d)), cell_count = static_cast<int>(order.cell_begin.size()) - 1;
  const Floats scale = hn::Set(d, static_cast<float>(order.resolution - 1));
  ChunkRows rows;
  ProductSums products;
  double total = 0.0;
  // within a cell A and B are polynomials, and J^T J gains a 16 x 16 block of its 8 nodes (docs/theory/representations.md §8)
  for (int c = 0; c < cell_count; ++c) {
    const Cell cell = cellAt(order.resolution, c);
    CellPolynomials polynomials;
    loadCell(order.resolution, cell, theta, polynomials);
    MomentSums moments;
    clearMoments(d, moments);
    Floats square_sum = hn::Zero(d);
    for (int i = 0; i < kSums; ++i) hn::Store(hn::Zero(d), d, products.lanes[i]);
    for (int begin = order.cell_begin[c]; begin < order.cell_begin[c + 1]; begin += kChunk) {
      const int count = std::min(kChunk, order.cell_begin[c + 1] - begin);
      for (int i = 0; i < count; i += lanes) {
        const CellPosition at = cellPosition(d, order, cell, scale, begin + i);
        const FieldPoint field = fieldPoint(d, polynomials, at);
        const Floats mask = hn::Load(d, &function.mask[begin + i]);
        const Floats residual = hn::Mul(mask, hn::Sub(field.value, hn::Load(d, &function.phi[begin + i])));
        const Floats by_a = hn::Mul(mask, field.by_a), by_b = hn::Mul(mask, field.by_b);
        square_sum = hn::MulAdd(residual, residual, square_sum);
        addMoments(at, hn::Mul(residual, by_a), hn::Mul(residual, by_b), moments);
        storeRows(d, at, by_a, by_b, i, rows);
      }
      addProducts(d, rows, count, products);
    }
    // from moments and products to the nodes, once a cell
    Nodes sums[4];
    sumMoments(d, moments, sums);
    addCellGradient(order.resolution, cell, sums, gradient);
    addBlock(d, order.resolution, cell, products, hessian);
    total += hn::GetLane(hn::SumOfLanes(d, square_sum));
  }
  return total;
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(addNormalEquations);

void fieldNormalEquations(const PointOrder& order, const WeightingFunction& function, const float* theta,
                          NormalEquations* equations) {
  const int r = order.resolution, count = 2 * r * r * r;
  alignas(64) float gradient[2 * 9 * 9 * 9] = {};
  // two nodes of a cell are at most 1 + r + r² apart, and each has two numbers
  equations->hessian.reset(count, 2 * (1 + r + r * r) + 1);
  equations->square_sum = HWY_DYNAMIC_DISPATCH(addNormalEquations)(order, function, theta, gradient, equations->hessian);
  equations->gradient.assign(gradient, gradient + count);
}

}  // namespace nlg
#endif  // HWY_ONCE
