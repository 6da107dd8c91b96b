#include "validate/generators/best_known.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <mutex>

#include "runtime_eval/numbers/random.h"
#include "tool/parallel_for.h"
#include "tool/progress.h"
#include "validate/generators/statistics.h"

namespace nlg {
namespace {

struct Candidate {
  const char* name;
  FitResult fit;
};

struct Thread {
  Thread(const FunctionSet& set, const LossOptions& loss) : meter(set, loss) {}
  ErrorMeter meter;
  FunctionChecker checker;
  NormalEquationsKernel kernel;
  std::vector<PopulationLeaks> leaks{kLongFitCount};
};

constexpr double kBudgets[] = {0.25, 0.5, 1.0, 2.0};

// What one function adds to every point.
struct FunctionCurves {
  std::vector<double> by_restarts, by_steps;
};

FunctionCurves curvesOf(const Generator& generator, const WeightingFunction& function, DirectOptions options,
                        NormalEquationsKernel* kernel) {
  const Representation& representation = generator.representation();
  const Theta theta0(generator.theta0(), generator.theta0() + representation.thetaCount());
  const int restarts = options.restarts, adam_steps = options.adam_steps;
  FunctionCurves curves;
  // the first restarts of more are those of fewer: one run gives the whole curve, and the budget of 1
  options.restarts = 2 * restarts;
  curves.by_restarts = fitDirect(representation, function, theta0, options, kernel).best_by_restarts;
  options.restarts = restarts;
  for (const double budget : kBudgets) {
    options.adam_steps = static_cast<int>(budget * adam_steps);
    curves.by_steps.push_back(budget == 1.0 ? curves.by_restarts[restarts]
                                            : fitDirect(representation, function, theta0, options, kernel).best.rmse);
  }
  return curves;
}

}  // namespace

const char* longFitName(LongFit fit) {
  constexpr const char* kNames[kLongFitCount] = {"direct", "adam_theta0", "lm_theta0", "adam_random", "best_known"};
  return kNames[static_cast<size_t>(fit)];
}

uint64_t startSeed(const ValidateOptions& options, uint64_t function) { return mixSeed(options.seed, function); }

FunctionFits fitLong(const Generator& generator, const WeightingFunction& function, const Theta& start,
                     const DirectOptions& options, NormalEquationsKernel* kernel) {
  // direct optimisation starts from theta0 and random thetas: a generator that errs does not lead it astray
  const Representation& representation = generator.representation();
  const Theta theta0(generator.theta0(), generator.theta0() + representation.thetaCount());
  const LevenbergMarquardtOptions polish = longLevenbergMarquardt(representation, options.levenberg_iterations);
  DirectResult direct;
  FitResult best = timedFit([&] {
    direct = fitDirect(representation, function, theta0, options, kernel);
    return direct.best;
  });
  FunctionFits result;
  result.fits = {best, direct.adam_from_theta0, direct.levenberg_from_theta0, direct.adam_from_random, {}};
  result.best_known_from = longFitName(LongFit::direct);
  // from the generator's theta, by both optimisers: a direct fit may miss the minimum beside it
  const auto adamPolicy = [&] {
    const FitResult adam =
        fitAdam(representation, function, start, refinementAdam(representation, directAdamSteps(representation, options)));
    return fitLevenbergMarquardt(representation, function, adam.theta, polish, kernel);
  };
  const Candidate others[] = {{"adam_policy", timedFit(adamPolicy)},
                              {"lm_policy", fitLevenbergMarquardt(representation, function, start, polish, kernel)}};
  // a best that is not finite gives way to any other
  double elapsed_us = best.elapsed_us;
  for (const Candidate& other : others) {
    elapsed_us += other.fit.elapsed_us;
    if (!(other.fit.rmse < best.rmse) && std::isfinite(best.rmse)) continue;
    best = other.fit;
    result.best_known_from = other.name;
  }
  best.elapsed_us = elapsed_us;  // nobody knows the best before all have run
  result.fits[static_cast<size_t>(LongFit::best_known)] = best;
  return result;
}

LongFits measureLongFits(const Generator& generator, const FunctionSet& set, const Populations& populations,
                         const std::vector<Theta>& starts, const ValidateOptions& options) {
  const Representation& representation = generator.representation();
  const std::vector<uint64_t>& sample = populations.sample();
  LongFits result;
  for (int f = 0; f < kLongFitCount; ++f) {
    result.words.push_back({longFitName(static_cast<LongFit>(f)), std::vector<MeasuredFunction>(sample.size()), {}});
  }
  // one kernel, checker and meter a thread: results go to their own place, so that nothing depends on the order
  const LossOptions loss = options.policy.check().loss();
  std::vector<std::unique_ptr<Thread>> threads;
  for (int t = 0; t < options.threadCount(); ++t) threads.push_back(std::make_unique<Thread>(set, loss));
  Progress progress(std::string(representationName(representation)) + ": functions fitted", static_cast<int64_t>(sample.size()));
  std::mutex mutex;
  int64_t done = 0;
  parallelFor(sample.size(), options.threadCount(), [&](uint64_t n, int t) {
    Thread& thread = *threads[t];
    const uint64_t function = sample[n];
    const StoredFunction stored = storedFunction(set, function);
    // the seed is the function's own: sharing functions out among threads changes no fit
    DirectOptions direct = options.direct;
    direct.seed = startSeed(options, function);
    const FunctionFits of_function =
        fitLong(generator, decodeFunction(stored, pointOrder(representation), loss), starts[n], direct, &thread.kernel);
    const std::array<FitResult, kLongFitCount>& fits = of_function.fits;
    // all of a function's fits are measured as the bake's thetas are: the same check, the same errors
    for (int f = 0; f < kLongFitCount; ++f) {
      const FunctionCheck check = thread.checker.check(representation, stored, fits[f].theta.data(), options.policy.check());
      const FunctionError error = thread.meter.measure(representation, fits[f].theta.data(), function);
      result.words[f].functions[n] = {function, error, !check.passes(options.policy.check()), true, fits[f].elapsed_us};
      thread.leaks[f].add(thread.meter.leakMagnitudes(), function, populations);
    }
    const std::lock_guard lock(mutex);
    ++result.best_known_from[of_function.best_known_from];
    progress.update(++done);
  });
  // leaks pool the points of all functions (docs/theory/errors.md), so that they are added at the end
  for (int f = 0; f < kLongFitCount; ++f) {
    for (const auto& thread : threads) result.words[f].leaks.add(thread->leaks[f]);
    result.words[f].mustBeFinite();
  }
  return result;
}

Convergence measureConvergence(const Generator& generator, const FunctionSet& set, const Populations& populations,
                               const LongFits& fits, const ValidateOptions& options) {
  // hard functions alone: there a budget can be too small
  const std::vector<uint64_t> functions = populations.hardOfSample(static_cast<uint64_t>(options.convergence_functions));
  std::vector<FunctionCurves> curves(functions.size());
  std::vector<NormalEquationsKernel> kernels(options.threadCount());
  Progress progress(std::string(representationName(generator.representation())) + ": convergence of direct fits",
                    static_cast<int64_t>(functions.size()));
  std::mutex mutex;
  int64_t done = 0;
  parallelFor(functions.size(), options.threadCount(), [&](uint64_t n, int thread) {
    const WeightingFunction function =
        decodeFunction(storedFunction(set, functions[n]), pointOrder(generator.representation()), options.policy.check().loss());
    DirectOptions direct = options.direct;
    direct.seed = startSeed(options, functions[n]);
    curves[n] = curvesOf(generator, function, direct, &kernels[thread]);
    const std::lock_guard lock(mutex);
    progress.update(++done);
  });
  // the mean over functions by restarts and by steps: where both are flat, direct optimisation has converged
  Convergence result;
  result.functions = functions.size();
  if (functions.empty()) return result;
  const auto meanAt = [&](std::vector<double> FunctionCurves::*curve, size_t i) {
    std::vector<double> errors;
    for (const FunctionCurves& one : curves) errors.push_back((one.*curve)[i]);
    return mean(errors);
  };
  // their best known errors, the level that the curves approach
  std::vector<double> best_known;
  for (const MeasuredFunction& one : fits.at(LongFit::best_known).functions) {
    if (std::binary_search(functions.begin(), functions.end(), one.function)) best_known.push_back(one.error.blend_rmse);
  }
  result.best_known_blend_rmse_mean = mean(best_known);
  for (int r = 0; r <= 2 * options.direct.restarts; ++r) {
    result.by_restarts.push_back({r, options.direct.adam_steps, meanAt(&FunctionCurves::by_restarts, r)});
  }
  for (size_t b = 0; b < std::size(kBudgets); ++b) {
    result.by_steps.push_back({options.direct.restarts, static_cast<int>(kBudgets[b] * options.direct.adam_steps),
                               meanAt(&FunctionCurves::by_steps, b)});
  }
  return result;
}

}  // namespace nlg
