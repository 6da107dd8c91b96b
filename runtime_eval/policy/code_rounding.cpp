#include "runtime_eval/policy/code_rounding.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/evaluator/theta_form.h"

namespace nlg {

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
  if (!factorAt(representation, present.theta.data())) return inSteps(present.theta);
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
  for (int length = kCodeGroup; length < K; length += kCodeGroup) {
    if (std::sqrt(before * before + added[length]) > allowed) continue;
    RoundedTheta shorter = inSteps(rounded(present.theta.data(), length));
    if (suffices(shorter.check)) return shorter;
  }
  return inSteps(rounded(present.theta.data(), K));
}

}  // namespace nlg
