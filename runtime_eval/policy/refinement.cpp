#include "runtime_eval/policy/refinement.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/fit/direct.h"

namespace nlg {
namespace {

constexpr int kNestedIterations = 40;    // on every grid, as direct optimisation has them
constexpr int64_t kMostSteps = 1 << 24;  // of one round, whatever the growth
constexpr int kRandomStarts = 3;         // tried beside theta0 where a network is stuck

constexpr float kFarOut = 4.0f;  // of a code's number, in deviations of a training set: no level has one

bool isFarOut(const Representation& code, const Theta& theta) {
  const float* deviation = code.dictionary->deviations();
  for (size_t k = 0; k < theta.size(); ++k) {
    if (!(std::abs(theta[k]) <= kFarOut * deviation[k])) return true;
  }
  return false;
}

}  // namespace

RefinementResult Refiner::refine(const Representation& representation, const StoredFunction& stored, const Theta& start,
                                 const Theta& theta0, const CheckOptions& check, const RefinementOptions& options) {
  RefinementResult result{start, checker_.check(representation, stored, start.data(), check)};
  if (result.check.passes(check)) return result;
  const WeightingFunction function = decodeFunction(stored, pointOrder(representation), check.loss());
  // trouble is the larger of the two errors over its threshold, so that no step trades one for the other
  const auto consider = [&](const FitResult& fit) {
    const FunctionCheck found = checker_.check(representation, stored, fit.theta.data(), check);
    result.steps += fit.steps;
    result.stop = fit.stop;
    if (found.trouble(check) < result.check.trouble(check)) result.theta = fit.theta, result.check = found;
  };
  const auto fails = [&] { return !result.check.passes(check); };
  const auto tryFrom = [&](const Theta& from, int steps) {
    if (fails()) consider(fitOn(representation, function, from, steps));
  };
  // What is stuck in a poor minimum gets round it from elsewhere; a field from coarse to fine. A code's fits end at one minimum, wherever
  // they start (docs/lab/training.md), but for starts so far out that all sigmoids are shut: these begin anew at the mean code.
  const auto tryOtherStarts = [&](int steps) {
    if (representation.isCode()) {
      if (isFarOut(representation, result.theta)) tryFrom(Theta(result.theta.size(), 0.0f), steps);
      return;
    }
    if (!theta0.empty()) tryFrom(theta0, steps);
    for (uint64_t seed = 1; seed <= kRandomStarts && representation.isNetwork(); ++seed) {
      tryFrom(randomTheta(representation, seed), steps);
    }
    if (representation.isField() && fails()) consider(fitNested(representation, function, kNestedIterations, &kernel_));
  };
  int64_t steps = options.refine_first_steps, last_steps = 0;
  bool other_starts_tried = false;
  for (int round = 0; round < options.refine_rounds && fails(); ++round) {
    // the last and longest round goes on from the best start that a shorter one has found
    if (last_steps > 0 && round + 1 == options.refine_rounds) {
      tryOtherStarts(static_cast<int>(last_steps));
      other_starts_tried = true;
    }
    if (!fails()) break;
    last_steps = std::min(steps, kMostSteps);
    tryFrom(result.theta, static_cast<int>(last_steps));
    // it converged: more steps from here would stay in the same minimum
    if (result.stop != FitStop::budget) break;
    steps = last_steps * options.refine_growth;
  }
  if (last_steps > 0 && !other_starts_tried) tryOtherStarts(static_cast<int>(last_steps));
  return result;
}

FitResult Refiner::fitOn(const Representation& representation, const WeightingFunction& function, const Theta& start, int steps) {
  // a field's normal equations are a band, a code's are few: there a step of Levenberg–Marquardt costs little more than one of Adam
  if (!representation.isNetwork()) {
    return fitLevenbergMarquardt(representation, function, start,
                                 refinementLevenbergMarquardt(representation, std::max(1, steps / 32)), &kernel_);
  }
  return fitAdam(representation, function, start, refinementAdam(representation, steps));
}

std::vector<uint32_t> worstFirst(const std::vector<FunctionCheck>& checks, const CheckOptions& options) {
  std::vector<uint32_t> failed;
  for (size_t i = 0; i < checks.size(); ++i) {
    if (!checks[i].passes(options)) failed.push_back(static_cast<uint32_t>(i));
  }
  std::stable_sort(failed.begin(), failed.end(),
                   [&](uint32_t a, uint32_t b) { return checks[a].trouble(options) > checks[b].trouble(options); });
  return failed;
}

}  // namespace nlg
