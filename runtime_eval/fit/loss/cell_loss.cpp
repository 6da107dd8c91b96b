// Losses of product fields and codes, cell after cell of their nodes.
#include "runtime_eval/fit/loss/loss_kernel.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/fit/loss/cell_loss.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include "runtime_eval/evaluator/brick-inl.h"

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {

// gradient   of kWithGradient; else null
template <bool kWithGradient>
HWY_INLINE double fieldLossOf(const PointOrder& order, const float* HWY_RESTRICT phi, const float* HWY_RESTRICT mask,
                              const float* HWY_RESTRICT theta, float* HWY_RESTRICT gradient) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d)), resolution = order.resolution;
  const int cell_count = static_cast<int>(order.cell_begin.size()) - 1;
  const Floats scale = hn::Set(d, static_cast<float>(resolution - 1));
  if constexpr (kWithGradient) std::fill_n(gradient, 2 * resolution * resolution * resolution, 0.0f);
  double total = 0.0;
  for (int c = 0; c < cell_count; ++c) {
    const Cell cell = cellAt(resolution, c);
    CellPolynomials polynomials;
    // within a cell A and B are polynomials of its centred coordinates (docs/theory/representations.md §8)
    loadCell(resolution, cell, theta, polynomials);
    MomentSums moments;
    clearMoments(d, moments);
    Floats square_sum = hn::Zero(d);
    for (int place = order.cell_begin[c]; place < order.cell_begin[c + 1]; place += lanes) {
      const CellPosition at = cellPosition(d, order, cell, scale, place);
      const FieldPoint field = fieldPoint(d, polynomials, at);
      const Floats weight = hn::LoadU(d, mask + place);
      const Floats residual = hn::Mul(weight, hn::Sub(field.value, hn::LoadU(d, phi + place)));
      square_sum = hn::MulAdd(residual, residual, square_sum);
      if constexpr (kWithGradient) {
        // the gradient as moments of the cell's monomials, taken to its nodes once
        const Floats delta = hn::Mul(weight, hn::Add(residual, residual));
        addMoments(at, hn::Mul(delta, field.by_a), hn::Mul(delta, field.by_b), moments);
      }
    }
    if constexpr (kWithGradient) {
      Nodes sums[4];
      sumMoments(d, moments, sums);
      addCellGradient(resolution, cell, sums, gradient);
    }
    total += hn::GetLane(hn::SumOfLanes(d, square_sum));
  }
  return total;
}

double fieldLossAndGradientVectors(const PointOrder& order, const float* HWY_RESTRICT phi, const float* HWY_RESTRICT mask,
                                   const float* HWY_RESTRICT theta, float* HWY_RESTRICT gradient) {
  return fieldLossOf<true>(order, phi, mask, theta, gradient);
}

double fieldLossVectors(const PointOrder& order, const float* HWY_RESTRICT phi, const float* HWY_RESTRICT mask,
                        const float* HWY_RESTRICT theta) {
  return fieldLossOf<false>(order, phi, mask, theta, nullptr);
}

// node_gradient   null, or r³ floats that the gradient by the logits of the nodes is added to
double codeLossVectors(const PointOrder& order, const float* HWY_RESTRICT phi, const float* HWY_RESTRICT mask,
                       const float* HWY_RESTRICT logits, float* HWY_RESTRICT node_gradient) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d)), r = order.resolution;
  const int cell_count = static_cast<int>(order.cell_begin.size()) - 1;
  const Floats scale = hn::Set(d, static_cast<float>(r - 1));
  BrickPolynomials polynomials;
  // a cell's logit is a polynomial of its centred coordinates: 7 multiply-adds a point (docs/theory/representations.md §8)
  brickPolynomials(r, logits, polynomials);
  double total = 0.0;
  for (int c = 0; c < cell_count; ++c) {
    const Cell cell = cellAt(r, c);
    Floats square_sum = hn::Zero(d), moment[8];
    for (Floats& sum : moment) sum = hn::Zero(d);
    for (int place = order.cell_begin[c]; place < order.cell_begin[c + 1]; place += lanes) {
      const CellPosition at = cellPosition(d, order, cell, scale, place);
      const Sigmoid s = sigmoid(d, cellLogit(d, polynomials, c, at));
      const Floats weight = hn::Load(d, mask + place), value = hn::Mul(hn::Load(d, &order.points.tent[place]), s.value);
      const Floats residual = hn::Mul(weight, hn::Sub(value, hn::Load(d, phi + place)));
      square_sum = hn::MulAdd(residual, residual, square_sum);
      if (node_gradient == nullptr) continue;
      // the derivative by the logit times each monomial: moments of the cell, taken to its nodes once
      Floats by_logit[8];
      by_logit[0] = hn::Mul(hn::Mul(weight, hn::Add(residual, residual)), hn::Mul(value, s.complement));
      by_logit[1] = hn::Mul(by_logit[0], at.x);
      for (int i = 0; i < 2; ++i) by_logit[2 + i] = hn::Mul(by_logit[i], at.y);
      for (int i = 0; i < 4; ++i) by_logit[4 + i] = hn::Mul(by_logit[i], at.z);
      for (int i = 0; i < 8; ++i) moment[i] = hn::Add(moment[i], by_logit[i]);
    }
    total += hn::GetLane(hn::SumOfLanes(d, square_sum));
    if (node_gradient == nullptr) continue;
    // the transpose of brickPolynomials
    float sum[8];
    for (int i = 0; i < 8; ++i) sum[i] = 0.125f * hn::GetLane(hn::SumOfLanes(d, moment[i]));
    for (int axis = 1; axis < 8; axis *= 2) {
      for (int i = 0; i < 8; ++i) {
        if (i & axis) continue;
        const float constant = sum[i], linear = sum[i | axis];
        sum[i] = constant - linear;
        sum[i | axis] = constant + linear;
      }
    }
    for (int i = 0; i < 8; ++i) node_gradient[cell.first_node + (i & 1) + r * ((i >> 1 & 1) + r * (i >> 2))] += sum[i];
  }
  return total;
}

void projectVectors(const Dictionary& dictionary, const float* HWY_RESTRICT node_gradient, float* HWY_RESTRICT gradient) {
  const FloatTag d;
  for (int k = 0; k < dictionary.codeCount(); ++k) {
    const float* row = dictionary.row(k);
    Floats sum = hn::Zero(d);
    for (size_t n = 0; n < dictionary.nodeStride(); n += hn::Lanes(d))
      sum = hn::MulAdd(hn::Load(d, row + n), hn::Load(d, node_gradient + n), sum);
    gradient[k] = hn::GetLane(hn::SumOfLanes(d, sum));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(fieldLossAndGradientVectors);
HWY_EXPORT(fieldLossVectors);
HWY_EXPORT(codeLossVectors);
HWY_EXPORT(projectVectors);

double fieldLossAndGradient(const PointOrder& order, const float* phi, const float* mask, const float* theta, float* gradient) {
  return HWY_DYNAMIC_DISPATCH(fieldLossAndGradientVectors)(order, phi, mask, theta, gradient);
}

double fieldLoss(const PointOrder& order, const float* phi, const float* mask, const float* theta) {
  return HWY_DYNAMIC_DISPATCH(fieldLossVectors)(order, phi, mask, theta);
}

double codeLossAndGradient(const Dictionary& dictionary, const float* phi, const float* mask, const float* z, float* gradient) {
  alignas(64) float logits[kMaxBrickStride], node_gradient[kMaxBrickStride];
  roundedLogits(dictionary, z, logits);
  std::fill_n(node_gradient, dictionary.nodeStride(), 0.0f);
  const double sum = HWY_DYNAMIC_DISPATCH(codeLossVectors)(cellOrder(dictionary.resolution()), phi, mask, logits, node_gradient);
  HWY_DYNAMIC_DISPATCH(projectVectors)(dictionary, node_gradient, gradient);
  return sum;
}

double codeLoss(const Dictionary& dictionary, const float* phi, const float* mask, const float* z) {
  alignas(64) float logits[kMaxBrickStride];
  roundedLogits(dictionary, z, logits);
  return HWY_DYNAMIC_DISPATCH(codeLossVectors)(cellOrder(dictionary.resolution()), phi, mask, logits, nullptr);
}

}  // namespace nlg
#endif  // HWY_ONCE
