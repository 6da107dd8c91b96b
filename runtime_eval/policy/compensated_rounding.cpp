#include "runtime_eval/policy/compensated_rounding.h"
#include "runtime_eval/evaluator/kernel_shape.h"

#include <algorithm>
#include <cmath>

namespace nlg {
namespace {

constexpr int kHessianPoints = 2000;
constexpr double kLeastDiagonal = 1e-9;  // of the mean diagonal entry, added to every one: numbers that change nothing have none

}  // namespace

bool CompensatedRounding::round(const Representation& network, const WeightingFunction& function,
                                const Compensation& compensation, float* theta) {
  const NetworkShape& shape = network.shape();
  const int D = shape.thetaCount(), hidden = shape.w3();
  float numbers[kMaxNetworkThetaCount];
  std::copy_n(theta, D, numbers);
  scaleHiddenLayers(network, numbers, compensation.most);
  kernel_.compute(network, function, numbers, &equations_, kHessianPoints, compensation.first_batch);
  if (!factor(compensation.damping)) return false;
  const double step = stepOf(shape);
  moved_.assign(D, 0.0);
  for (int i = 0; i < D; ++i) {
    double best = numbers[i];
    for (int j = 0; j < i; ++j) best -= rows_[i * D + j] * moved_[j];
    const double taken =
        i < hidden ? step * std::clamp<double>(std::nearbyint(best / step), -kMostThetaSteps, kMostThetaSteps) : best;
    if (!std::isfinite(static_cast<float>(taken))) return false;
    moved_[i] = taken - numbers[i];
    numbers[i] = static_cast<float>(taken);
  }
  std::copy_n(numbers, D, theta);
  return true;
}

bool CompensatedRounding::factor(double damping) {
  const SymmetricBand& hessian = equations_.hessian;
  const int D = hessian.count();
  double mean = 0.0;
  for (int i = 0; i < D; ++i) mean += hessian.at(i, i) / D;
  rows_.resize(static_cast<size_t>(D) * D);
  for (int i = 0; i < D; ++i) {
    for (int j = 0; j < i; ++j) rows_[i * D + j] = hessian.at(i, j);
    rows_[i * D + i] = (1.0 + damping) * hessian.at(i, i) + kLeastDiagonal * mean;
  }
  // from the last number up: what is left of H once that one is where it is best
  for (int i = D - 1; i >= 0; --i) {
    double* row = &rows_[i * D];
    const double diagonal = row[i];
    if (!(diagonal > 0.0) || !std::isfinite(diagonal)) return false;
    for (int j = 0; j < i; ++j) {
      const double share = row[j] / diagonal;
      for (int k = 0; k <= j; ++k) rows_[j * D + k] -= share * row[k];
    }
    for (int j = 0; j < i; ++j) row[j] /= diagonal;
  }
  return true;
}

}  // namespace nlg
