#include "runtime_eval/fit/loss/loss_kernel.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/fit/loss/field_loss.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include "runtime_eval/evaluator/product_field-inl.h"

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {

double fieldLossAndGradientVectors(const PointOrder& order, const float* HWY_RESTRICT phi, const float* HWY_RESTRICT mask,
                                   const float* HWY_RESTRICT theta, float* HWY_RESTRICT gradient) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d)), resolution = order.resolution;
  const int cell_count = static_cast<int>(order.cell_begin.size()) - 1;
  const Floats scale = hn::Set(d, static_cast<float>(resolution - 1));
  std::fill_n(gradient, 2 * resolution * resolution * resolution, 0.0f);
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
      // the gradient as moments of the cell's monomials, taken to its nodes once
      const Floats delta = hn::Mul(weight, hn::Add(residual, residual));
      addMoments(at, hn::Mul(delta, field.by_a), hn::Mul(delta, field.by_b), moments);
    }
    Nodes sums[4];
    sumMoments(d, moments, sums);
    addCellGradient(resolution, cell, sums, gradient);
    total += hn::GetLane(hn::SumOfLanes(d, square_sum));
  }
  return total;
}

double fieldLossVectors(const PointOrder& order, const float* HWY_RESTRICT phi, const float* HWY_RESTRICT mask,
                        const float* HWY_RESTRICT theta) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d)), cell_count = static_cast<int>(order.cell_begin.size()) - 1;
  const Floats scale = hn::Set(d, static_cast<float>(order.resolution - 1));
  double total = 0.0;
  for (int c = 0; c < cell_count; ++c) {
    const Cell cell = cellAt(order.resolution, c);
    CellPolynomials polynomials;
    loadCell(order.resolution, cell, theta, polynomials);
    Floats square_sum = hn::Zero(d);
    for (int place = order.cell_begin[c]; place < order.cell_begin[c + 1]; place += lanes) {
      const CellPosition at = cellPosition(d, order, cell, scale, place);
      const Floats value = fieldPoint(d, polynomials, at).value;
      const Floats residual = hn::Mul(hn::LoadU(d, mask + place), hn::Sub(value, hn::LoadU(d, phi + place)));
      square_sum = hn::MulAdd(residual, residual, square_sum);
    }
    total += hn::GetLane(hn::SumOfLanes(d, square_sum));
  }
  return total;
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(fieldLossAndGradientVectors);
HWY_EXPORT(fieldLossVectors);

double fieldLossAndGradient(const PointOrder& order, const float* phi, const float* mask, const float* theta, float* gradient) {
  return HWY_DYNAMIC_DISPATCH(fieldLossAndGradientVectors)(order, phi, mask, theta, gradient);
}

double fieldLoss(const PointOrder& order, const float* phi, const float* mask, const float* theta) {
  return HWY_DYNAMIC_DISPATCH(fieldLossVectors)(order, phi, mask, theta);
}

}  // namespace nlg
#endif  // HWY_ONCE
