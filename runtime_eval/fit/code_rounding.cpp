#include "runtime_eval/fit/code_rounding.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/evaluator/theta_form.h"

namespace nlg {
namespace {

// Steps that bring a shorter code to its own minimum, where leaving numbers out moved it too far for the second order.
constexpr int kShorterIterations = 3;
// Lengths whose predicted RMSE is above so many times what is allowed are not tried.
constexpr double kHopeless = 1.5;
constexpr double kLeastDiagonal = 1e-9;  // of the mean diagonal entry, added to every one

}  // namespace

bool CodeRounding::factorAt(const Representation& representation, const float* z) {
  fit_.equationsAt(representation, function_, {}, z, &equations_);
  const int K = equations_.count;
  upper_.assign(equations_.matrix.begin(), equations_.matrix.end());
  double mean = 0.0;
  for (int i = 0; i < K; ++i) mean += upper_[i * K + i] / K;
  for (int i = 0; i < K; ++i) upper_[i * K + i] += kLeastDiagonal * mean;
  for (int i = 0; i < K; ++i) {
    double* pivot = &upper_[i * K];
    if (!(pivot[i] > 0.0) || !std::isfinite(pivot[i])) return false;
    const double inverse = 1.0 / std::sqrt(pivot[i]);
    for (int k = i; k < K; ++k) pivot[k] *= inverse;
    for (int j = i + 1; j < K; ++j) {
      for (int k = j; k < K; ++k) upper_[j * K + k] -= pivot[j] * pivot[k];
    }
  }
  return true;
}

Theta CodeRounding::rounded(const float* z, int length) const {
  const int K = equations_.count;
  Theta theta(static_cast<size_t>(K), 0.0f);
  double moved[kMaxCodeCount] = {};
  for (int i = K - 1; i >= 0; --i) {
    double best = z[i];
    for (int k = i + 1; k < K; ++k) best -= upper_[i * K + k] * moved[k] / upper_[i * K + i];
    if (i < length) theta[i] = static_cast<float>(std::clamp<double>(std::nearbyint(best), -kMostCodeSteps, kMostCodeSteps));
    moved[i] = theta[i] - z[i];
  }
  return theta;
}

RoundedTheta CodeRounding::round(const Representation& representation, const StoredFunction& function, const RoundedTheta& present,
                                 const CheckOptions& check) {
  const int K = representation.code_count;
  decodeFunction(function, pointOrder(representation), check.dark_weight, &function_);
  const auto inSteps = [&](Theta theta) {
    roundTheta(representation, ThetaPrecision::int8, theta.data());
    const FunctionCheck found = checker_.check(representation, function, theta.data(), check);
    return RoundedTheta{std::move(theta), found};
  };
  if (!factorAt(representation, present.theta.data())) return inSteps(present.theta);
  const double before = present.check.weighedRmse(check), allowed = std::max(options_.code_enough_rmse, options_.code_flat_ratio * before);
  const bool must_pass = present.check.passes(check);
  const auto suffices = [&](const FunctionCheck& found) {
    return found.weighedRmse(check) <= allowed && (!must_pass || found.passes(check));
  };
  // what leaving out the numbers from i on adds to the mean square
  std::vector<double> added(static_cast<size_t>(K) + 1, 0.0);
  for (int i = K - 1; i >= 0; --i) {
    double sum = 0.0;
    for (int k = i; k < K; ++k) sum += upper_[i * K + k] * present.theta[k];
    added[i] = added[i + 1] + sum * sum / std::max(1, present.check.valid_count);
  }
  const std::vector<double> full_upper = upper_;
  for (int length = kCodeGroup; length < K; length += kCodeGroup) {
    if (std::sqrt(before * before + added[length]) > kHopeless * allowed) continue;
    RoundedTheta shorter = inSteps(rounded(present.theta.data(), length));
    if (suffices(shorter.check)) return shorter;
    Theta fitted = shorter.theta;
    fit_.iterate(representation, function_, {.iterations = kShorterIterations, .is_ramped = false}, length, fitted.data());
    if (factorAt(representation, fitted.data())) shorter = inSteps(rounded(fitted.data(), length));
    upper_ = full_upper;
    if (suffices(shorter.check)) return shorter;
  }
  return inSteps(rounded(present.theta.data(), K));
}

}  // namespace nlg
