#include "runtime_eval/fit/direct.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/support/random.h"

namespace nlg {

DirectResult fitDirect(const Representation& representation, const WeightingFunction& function, const Theta& theta0,
                       const DirectOptions& options, NormalEquationsKernel* kernel) {
  const LevenbergMarquardtOptions polish{.iterations = options.levenberg_iterations};
  DirectResult result;
  const auto consider = [&](const FitResult& candidate) {
    // also when the best so far is not finite, which a theta0 of NaN would make it
    if (candidate.rmse < result.best.rmse || !std::isfinite(result.best.rmse)) result.best = candidate;
  };
  const auto polished = [&](const FitResult& fit) {
    return fitLevenbergMarquardt(representation, function, fit.theta, polish, kernel);
  };
  result.levenberg_from_theta0 = fitLevenbergMarquardt(representation, function, theta0, polish, kernel);
  result.adam_from_theta0 = fitAdam(representation, function, theta0, refinementAdam(representation, options.adam_steps));
  result.best = result.levenberg_from_theta0;
  consider(polished(result.adam_from_theta0));
  for (int restart = 0; restart < options.restarts; ++restart) {
    const Theta start = randomTheta(representation, mixSeed(options.seed, restart));
    const FitResult fit = fitAdam(representation, function, start, randomStartAdam(options.adam_steps));
    if (restart == 0) result.adam_from_random = fit;
    consider(polished(fit));
  }
  return result;
}

FitResult fitStart(const Representation& representation, const WeightingFunction& function, const StartOptions& options,
                   NormalEquationsKernel* kernel) {
  std::vector<FitResult> fits;
  for (int i = 0; i < options.candidates; ++i) {
    const Theta start = randomTheta(representation, mixSeed(options.seed, i));
    fits.push_back(fitAdam(representation, function, start, randomStartAdam(options.candidate_steps)));
  }
  const auto by_rmse = [](const FitResult& a, const FitResult& b) { return a.rmse < b.rmse; };
  std::sort(fits.begin(), fits.end(), by_rmse);
  fits.resize(std::min<size_t>(fits.size(), options.finalists));
  for (FitResult& fit : fits) {
    fit = fitAdam(representation, function, fit.theta, refinementAdam(representation, options.final_steps));
    fit = fitLevenbergMarquardt(representation, function, fit.theta, {.iterations = options.levenberg_iterations}, kernel);
  }
  return *std::min_element(fits.begin(), fits.end(), by_rmse);
}

}  // namespace nlg
