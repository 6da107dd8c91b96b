#include "runtime_eval/fit/loss/loss_kernel.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "runtime_eval/fit/loss/code_loss.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include "runtime_eval/evaluator/brick-inl.h"

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {

// node_gradient   null, or r³ floats that the gradient by the logits of the nodes is added to
double lossVectors(const PointOrder& order, const float* HWY_RESTRICT phi, const float* HWY_RESTRICT mask,
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

HWY_EXPORT(lossVectors);
HWY_EXPORT(projectVectors);

double codeLossAndGradient(const Dictionary& dictionary, const float* phi, const float* mask, const float* z, float* gradient) {
  alignas(64) float logits[kMaxBrickStride], node_gradient[kMaxBrickStride];
  roundedLogits(dictionary, z, logits);
  std::fill_n(node_gradient, dictionary.nodeStride(), 0.0f);
  const double sum = HWY_DYNAMIC_DISPATCH(lossVectors)(cellOrder(dictionary.resolution()), phi, mask, logits, node_gradient);
  HWY_DYNAMIC_DISPATCH(projectVectors)(dictionary, node_gradient, gradient);
  return sum;
}

double codeLoss(const Dictionary& dictionary, const float* phi, const float* mask, const float* z) {
  alignas(64) float logits[kMaxBrickStride];
  roundedLogits(dictionary, z, logits);
  return HWY_DYNAMIC_DISPATCH(lossVectors)(cellOrder(dictionary.resolution()), phi, mask, logits, nullptr);
}

}  // namespace nlg
#endif  // HWY_ONCE
