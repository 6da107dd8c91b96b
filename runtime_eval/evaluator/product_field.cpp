#include "runtime_eval/evaluator/product_field.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/evaluator/dictionary.h"
#include "runtime_eval/numbers/logistic.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/evaluator/product_field.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include "runtime_eval/evaluator/product_field-inl.h"

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {

void evaluateCells(const PointOrder& order, const float* HWY_RESTRICT theta, float* HWY_RESTRICT values) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d)), cell_count = static_cast<int>(order.cell_begin.size()) - 1;
  const Floats scale = hn::Set(d, static_cast<float>(order.resolution - 1));
  for (int c = 0; c < cell_count; ++c) {
    const Cell cell = cellAt(order.resolution, c);
    CellPolynomials polynomials;
    loadCell(order.resolution, cell, theta, polynomials);
    for (int place = order.cell_begin[c]; place < order.cell_begin[c + 1]; place += lanes) {
      const CellPosition at = cellPosition(d, order, cell, scale, place);
      const Floats a = clampToUnit(d, cellValue<0>(d, polynomials, at));
      hn::StoreU(hn::Mul(a, sigmoid(d, cellValue<1>(d, polynomials, at)).value), d, values + place);
    }
  }
}

// So many points at a time: what passes between the steps below stays in the level-1 cache.
constexpr int kBlock = 128;

// Low node and share of the way to the next one along one axis.
HWY_INLINE void locate(FloatTag d, Floats position, int resolution, int32_t* HWY_RESTRICT node, float* HWY_RESTRICT share) {
  const hn::RebindToSigned<FloatTag> di;
  const Floats half = hn::Set(d, 0.5f * static_cast<float>(resolution - 1)),
               last = hn::Set(d, static_cast<float>(resolution - 1));
  const Floats along = hn::Max(hn::Zero(d), hn::Min(last, hn::MulAdd(position, half, half)));
  // limited as an integer too: a position that is no number must not lead outside theta
  const auto low = hn::Max(hn::Zero(di), hn::Min(hn::Set(di, resolution - 2), hn::ConvertTo(di, along)));
  hn::Store(low, di, node);
  hn::Store(hn::Sub(along, hn::ConvertTo(d, low)), d, share);
}

// `count` points, a multiple of the vector's length: A and B of every point are gathered as the row of two nodes along x that is
// interpolated in y and z; the rest is done for a vector of points at once.
void evaluateBlock(int resolution, const PointSet& points, int first, int count, const float* HWY_RESTRICT theta,
                   float* HWY_RESTRICT values) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d)), y = 2 * resolution, z = 2 * resolution * resolution;
  alignas(64) int32_t node[3][kBlock];
  alignas(64) float share[3][kBlock], row[4 * kBlock];
  for (int i = 0; i < count; i += lanes) {
    locate(d, hn::Load(d, &points.x[first + i]), resolution, &node[0][i], &share[0][i]);
    locate(d, hn::Load(d, &points.y[first + i]), resolution, &node[1][i], &share[1][i]);
    locate(d, hn::Load(d, &points.z[first + i]), resolution, &node[2][i], &share[2][i]);
  }
  // no gathers: a point loads four rows of A, B, A, B and blends them in y and z
  const auto between = [](Nodes low, Nodes high, float part) { return multiplyAdd(part, subtract(high, low), low); };
  for (int i = 0; i < count; ++i) {
    const float* corner = theta + 2 * node[0][i] + y * node[1][i] + z * node[2][i];
    const Nodes low = between(loadNodes(corner), loadNodes(corner + y), share[1][i]);
    const Nodes high = between(loadNodes(corner + z), loadNodes(corner + z + y), share[1][i]);
    storeNodes(between(low, high, share[2][i]), row + 4 * i);
  }
  // the blend along x and the sigmoid are whole vectors again
  for (int i = 0; i < count; i += lanes) {
    Floats a0, b0, a1, b1;
    hn::LoadInterleaved4(d, row + 4 * i, a0, b0, a1, b1);
    const Floats along_x = hn::Load(d, &share[0][i]);
    const Floats a = hn::MulAdd(along_x, hn::Sub(a1, a0), a0), b = hn::MulAdd(along_x, hn::Sub(b1, b0), b0);
    hn::StoreU(hn::Mul(clampToUnit(d, a), sigmoid(d, b).value), d, values + i);
  }
}

void evaluatePoints(int resolution, const PointSet& points, const float* HWY_RESTRICT theta, float* HWY_RESTRICT values) {
  for (int i = 0; i < points.padded_count; i += kBlock) {
    evaluateBlock(resolution, points, i, std::min(kBlock, points.padded_count - i), theta, values + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(evaluateCells);
HWY_EXPORT(evaluatePoints);

void evaluateField(int resolution, const PointSet& points, const float* theta, float* values) {
  HWY_DYNAMIC_DISPATCH(evaluatePoints)(resolution, points, theta, values);
}

void evaluateFieldCells(const PointOrder& order, const float* theta, float* values) {
  HWY_DYNAMIC_DISPATCH(evaluateCells)(order, theta, values);
}

void resampleField(int from, const float* theta, int to, float* result) {
  for (int i = 0; i < to * to * to; ++i) {
    const int along[3] = {i % to, i / to % to, i / (to * to)};
    double sums[2] = {};
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1.0;
      int index = 0, stride = 1;
      for (int axis = 0; axis < 3; ++axis, stride *= from) {
        // in integers, so that a node of both grids takes its value from one node alone
        const int position = along[axis] * (from - 1), low = std::min(position / (to - 1), from - 2);
        const double share = static_cast<double>(position - low * (to - 1)) / (to - 1);
        const int high = corner >> axis & 1;
        weight *= high ? share : 1.0 - share;
        index += (low + high) * stride;
      }
      for (int channel = 0; channel < 2; ++channel) sums[channel] += weight * theta[2 * index + channel];
    }
    for (int channel = 0; channel < 2; ++channel) result[2 * i + channel] = static_cast<float>(sums[channel]);
  }
}

double evaluateFieldReference(int resolution, const LocalPoint& point, const double* theta) {
  double a = 0.0, b = 0.0;
  forEachNode(placeAmongNodes<double>(resolution, point), resolution, [&](int node, double weight) {
    a += weight * theta[2 * node];
    b += weight * theta[2 * node + 1];
  });
  return std::clamp(a, 0.0, 1.0) * logistic(b);
}

}  // namespace nlg
#endif  // HWY_ONCE
