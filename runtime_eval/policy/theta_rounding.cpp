#include "runtime_eval/policy/theta_rounding.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/fit/last_layer.h"

namespace nlg {
namespace {

constexpr int kHessianPoints = 2000;
constexpr double kLeastDiagonal = 1e-9;  // of the mean diagonal entry, added to every one: numbers that change nothing have none

// Roundings to bytes are tried one after another, until the error is at most kRoundingExcess times what it was, or has grown by no
// more than kRoundingAdds. In the first kRoundingWays each number is rounded for itself; in those of kCompensatedWays numbers make up
// for each other. Few theta need a second one (docs/lab/training.md).
constexpr int kRoundingWays = 4;
struct CompensatedWay {
  double share;  // of the steps
  double damping;
  int first_batch;
};
constexpr CompensatedWay kCompensatedWays[] = {{0.976, 0.03, 0}, {0.929, 0.1, 3}, {0.953, 0.01, 6}, {0.882, 0.03, 9}};
constexpr double kRoundingExcess = 1.02, kRoundingAdds = 5e-5;

// Fits drive the logits of product fields to any size where a larger one changes nothing. The largest half stands for all beyond it;
// what that does to the function, the check finds.
Theta limited(Theta theta) {
  for (float& number : theta) number = std::clamp(number, -kMaxHalf, kMaxHalf);
  return theta;
}

void roundLimited(const Representation& representation, ThetaPrecision precision, Theta* theta) {
  *theta = limited(std::move(*theta));
  roundTheta(representation, precision, theta->data());
}

}  // namespace

bool CompensatedRounding::round(const Representation& network, const WeightingFunction& function,
                                const Compensation& compensation, float* theta) {
  const NetworkShape& shape = network.shape();
  const int D = shape.thetaCount(), hidden = shape.w3();
  float numbers[kMaxNetworkThetaCount];
  std::copy_n(theta, D, numbers);
  // scaled first, so that one step holds for all hidden numbers (theta_form.h)
  scaleHiddenLayers(network, numbers, compensation.most);
  kernel_.compute(network, function, numbers, &equations_, kHessianPoints, compensation.first_batch);
  if (!factor(compensation.damping)) return false;
  const double step = stepOf(shape);
  moved_.assign(D, 0.0);
  // Babai's nearest plane (docs/theory/math.md §5): each number at its optimum given those before; the last layer stays exact
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
  // damped, so that numbers which hardly matter do not move far to make up for others
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

bool CodeRounding::factorAt(const Representation& representation, const float* z) {
  fit_.equationsAt(representation, function_, {}, z, &equations_);
  return equations_.factor();
}

Theta CodeRounding::rounded(const float* z, int length) const {
  const int K = equations_.count;
  Theta theta(static_cast<size_t>(K), 0.0f);
  const float step = std::ldexp(1.0f, codeExponent(K, z));
  float moved[kMaxCodeCount] = {};
  for (int i = K - 1; i >= 0; --i) {
    const float* row = &equations_.matrix[static_cast<size_t>(i) * K];
    float sum = 0.0f;
    for (int k = i + 1; k < K; ++k) sum += row[k] * moved[k];
    const float best = z[i] - sum / row[i];
    constexpr auto kMost = static_cast<float>(kMostCodeSteps);
    if (i < length) theta[i] = step * std::clamp(std::nearbyint(best / step), -kMost, kMost);
    moved[i] = theta[i] - z[i];
  }
  return theta;
}

RoundedTheta CodeRounding::round(const Representation& representation, const StoredFunction& function,
                                 const RoundedTheta& present, const CheckOptions& check) {
  const int K = representation.code_count;
  decodeFunction(function, pointOrder(representation), check.loss(), &function_);
  const auto inSteps = [&](Theta theta) {
    roundTheta(representation, ThetaPrecision::int8, theta.data());
    const FunctionCheck found = checker_.check(representation, function, theta.data(), check);
    return RoundedTheta{std::move(theta), found};
  };
  // without equations each number is rounded for itself
  if (!factorAt(representation, present.theta.data())) return inSteps(present.theta);
  // how much a shorter code may err: a little more than the full one, or as much as is exact enough anyway
  const double before = present.check.blend_rmse,
               allowed = std::max(options_.code_enough_rmse, options_.code_flat_ratio * before);
  const bool must_pass = present.check.passes(check);
  const auto suffices = [&](const FunctionCheck& found) {
    return found.blend_rmse <= allowed && (!must_pass || found.passes(check));
  };
  // what leaving out the numbers from i on adds to the mean square
  std::vector<double> added(static_cast<size_t>(K) + 1, 0.0);
  for (int i = K - 1; i >= 0; --i) {
    double sum = 0.0;
    for (int k = i; k < K; ++k) sum += double{equations_.matrix[i * K + k]} * present.theta[k];
    added[i] = added[i + 1] + sum * sum / std::max(1, present.check.valid_count);
  }
  // the shortest first; where H already predicts too much error, none is made
  for (int length = kCodeGroup; length < K; length += kCodeGroup) {
    if (std::sqrt(before * before + added[length]) > allowed) continue;
    RoundedTheta shorter = inSteps(rounded(present.theta.data(), length));
    if (suffices(shorter.check)) return shorter;
  }
  return inSteps(rounded(present.theta.data(), K));
}

ThetaRounding::ThetaRounding(const PolicyOptions& options) {
  if (options.theta_precision != ThetaPrecision::int8) return;
  compensated_ = std::make_unique<CompensatedRounding>();
  code_ = std::make_unique<CodeRounding>(options);
}

RoundedTheta ThetaRounding::round(const Representation& representation, const StoredFunction& function,
                                  const RoundedTheta& present, const CheckOptions& check) {
  // product fields stay in float16
  if (compensated_ == nullptr || representation.isField()) return roundToHalves(representation, function, present.theta, check);
  if (representation.isCode()) return code_->round(representation, function, present, check);
  return roundToBytes(representation, function, present, check);
}

RoundedTheta ThetaRounding::roundToHalves(const Representation& representation, const StoredFunction& function,
                                          const Theta& theta, const CheckOptions& check) {
  RoundedTheta rounded{theta, {}};
  roundLimited(representation, ThetaPrecision::float16, &rounded.theta);
  rounded.check = checker_.check(representation, function, rounded.theta.data(), check);
  return rounded;
}

// The last layer makes up for what the hidden ones lose; solved before it is rounded itself, it may still be the worse one.
RoundedTheta ThetaRounding::roundToBytes(const Representation& network, const StoredFunction& function,
                                         const RoundedTheta& present, const CheckOptions& check) {
  // where a theta passes, its blend RMSE alone is what counts
  const auto badness = [&](const FunctionCheck& of) {
    return of.passes(check) ? of.blend_rmse / check.tau_blend : of.trouble(check);
  };
  const double before = badness(present.check),
               enough = std::max(kRoundingExcess * before, before + kRoundingAdds / check.tau_blend);
  RoundedTheta best;
  const auto isDone = [&] { return !best.theta.empty() && badness(best.check) <= enough; };
  const auto offer = [&](Theta theta) {
    roundLimited(network, ThetaPrecision::int8, &theta);
    const FunctionCheck found = checker_.check(network, function, theta.data(), check);
    if (best.theta.empty() || badness(found) < badness(best.check)) best = {std::move(theta), found};
  };
  const Theta start = limited(present.theta);  // scaled units of larger numbers would leave the range of floats
  const WeightingFunction values = decodeFunction(function, pointOrder(network), check.loss());
  const auto offerSolvedAndNot = [&](Theta theta) {
    Theta solved = theta;
    if (solveLastLayer(network, values, solved.data())) offer(std::move(solved));
    if (!isDone()) offer(std::move(theta));
  };
  const int most = enoughThetaSteps(network.shape());
  // each number for itself: other scales of the first layer round otherwise
  for (int way = 0; way < kRoundingWays && !isDone(); ++way) {
    Theta theta = start;
    roundHiddenLayers(network, theta.data(), {most - 2 * way, most});
    offerSolvedAndNot(std::move(theta));
  }
  if (isDone()) return best;
  // numbers that make up for each other, at other scales, dampings and points of H
  for (const CompensatedWay& way : kCompensatedWays) {
    Theta theta = start;
    const auto steps = static_cast<int>(std::lround(way.share * most));
    const Compensation compensation{{steps, steps}, way.damping, way.first_batch};
    if (isDone() || !compensated_->round(network, values, compensation, theta.data())) continue;
    offerSolvedAndNot(std::move(theta));
  }
  return best;
}

}  // namespace nlg
