#include "runtime_eval/fit/direct.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/evaluator/product_field.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {

int directAdamSteps(const Representation& representation, const DirectOptions& options) {
  const int64_t points = int64_t{options.adam_steps} * kMinibatchPointCount;
  return static_cast<int>(points / std::min(pointOrder(representation).minibatch_places, kSupportPointCount));
}

FitResult fitDirect(const Representation& representation, const WeightingFunction& function, const Theta& theta0,
                    const DirectOptions& options, NormalEquationsKernel* kernel) {
  // every start is polished by a long LM, so that "direct" stands for a minimum and not for Adam's budget
  const LevenbergMarquardtOptions polish = longLevenbergMarquardt(representation, options.levenberg_iterations);
  const int adam_steps = directAdamSteps(representation, options);
  FitResult best = fitLevenbergMarquardt(representation, function, theta0, polish, kernel);
  const auto consider = [&](const FitResult& candidate) {
    // also when the best so far is not finite, which a theta0 of NaN would make it
    if (candidate.rmse < best.rmse || !std::isfinite(best.rmse)) best = candidate;
  };
  const auto polished = [&](const FitResult& fit) {
    return fitLevenbergMarquardt(representation, function, fit.theta, polish, kernel);
  };
  consider(polished(fitAdam(representation, function, theta0, refinementAdam(representation, adam_steps))));
  // a converged coarse field continues on more nodes from the error it had reached (docs/theory/representations.md §8)
  if (representation.isField()) consider(fitNested(representation, function, options.levenberg_iterations, kernel));
  for (int restart = 0; restart < options.restarts; ++restart) {
    // Adam finds a basin, LM its bottom; for codes LM from the start itself is tried as well
    const Theta start = randomTheta(representation, mixSeed(options.seed, restart));
    consider(polished(fitAdam(representation, function, start, randomStartAdam(representation, adam_steps))));
    if (representation.isCode()) consider(fitLevenbergMarquardt(representation, function, start, polish, kernel));
  }
  return best;
}

namespace {

// The tent, in A; B far enough on its flat side to matter little, and near enough to be moved.
Theta tentField() {
  constexpr int kResolution = 3;
  Theta theta;
  for (int node = 0; node < kResolution * kResolution * kResolution; ++node) {
    // the tent is 1 at the middle node and 0 at all others
    theta.push_back(node == 13 ? 1.0f : 0.0f);
    theta.push_back(2.0f);
  }
  return theta;
}

}  // namespace

FitResult fitNested(const Representation& representation, const WeightingFunction& function, int iterations,
                    NormalEquationsKernel* kernel) {
  return timedFit([&] {
    const PointOrder& order = pointOrder(representation);
    FitResult fit;
    fit.theta = tentField();
    int resolution = 3, steps = 0;
    while (true) {
      const Representation grid = Representation::productField(resolution);
      fit = fitLevenbergMarquardt(grid, reordered(function, order, pointOrder(grid)), fit.theta,
                                  refinementLevenbergMarquardt(grid, iterations), kernel);
      fit.steps = steps += fit.steps;
      if (resolution == representation.resolution) return fit;
      // 3 → 5 → 9 or 3 → 7: each grid holds the nodes of the one before, so that resampling keeps the field
      const int next = resolution == 3 && representation.resolution == 9 ? 5 : representation.resolution;
      Theta finer(Representation::productField(next).thetaCount());
      resampleField(resolution, fit.theta.data(), next, finer.data());
      fit.theta = finer;
      resolution = next;
    }
  });
}

FitResult fitStart(const Representation& representation, const WeightingFunction& function, const StartOptions& options,
                   NormalEquationsKernel* kernel) {
  if (representation.isField()) return fitNested(representation, function, options.levenberg_iterations, kernel);
  // networks have many minima: short fits of many starts choose the basins, long fits of the best few find their bottoms
  std::vector<FitResult> fits;
  for (int i = 0; i < options.candidates; ++i) {
    const Theta start = randomTheta(representation, mixSeed(options.seed, i));
    fits.push_back(fitAdam(representation, function, start, randomStartAdam(representation, options.candidate_steps)));
  }
  const auto by_rmse = [](const FitResult& a, const FitResult& b) { return a.rmse < b.rmse; };
  std::sort(fits.begin(), fits.end(), by_rmse);
  fits.resize(std::min<size_t>(fits.size(), options.finalists));
  for (FitResult& fit : fits) {
    fit = fitAdam(representation, function, fit.theta, refinementAdam(representation, options.final_steps));
    fit = fitLevenbergMarquardt(representation, function, fit.theta,
                                refinementLevenbergMarquardt(representation, options.levenberg_iterations), kernel);
  }
  return *std::min_element(fits.begin(), fits.end(), by_rmse);
}

}  // namespace nlg
