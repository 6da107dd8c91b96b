#include "validate/stability/fit_verdict.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/numbers/finite.h"

namespace nlg {

FitVerdict judge(const Representation& representation, const WeightingFunction& function, const Theta& start,
                 const FitResult& fit, int budget) {
  FitVerdict verdict;
  verdict.within_budget = fit.steps <= budget;
  const double before = functionRmse(representation, function, start.data());
  if (!std::isfinite(before)) {
    // bit for bit: a NaN is not equal to itself
    const bool as_given = std::equal(start.begin(), start.end(), fit.theta.begin(),
                                     [](float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); });
    verdict.no_worse = as_given && fit.stop == FitStop::not_finite;
    return verdict;
  }
  verdict.finite = allFinite(fit.theta) && std::isfinite(fit.rmse);
  verdict.no_worse = functionRmse(representation, function, fit.theta.data()) <= before;
  return verdict;
}

}  // namespace nlg
