#include "validate/generators/best_known.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "runtime_eval/numbers/random.h"
#include "tool/parallel_for.h"
#include "tool/progress.h"

namespace nlg {

const char* longFitName(LongFit fit) {
  constexpr const char* kNames[kLongFitCount] = {"direct", "best_known"};
  return kNames[static_cast<size_t>(fit)];
}

uint64_t startSeed(const ValidateOptions& options, uint64_t function) { return mixSeed(options.seed, function); }

std::array<FitResult, kLongFitCount> fitLong(const Generator& generator, const WeightingFunction& function, const Theta& start,
                                             const DirectOptions& options, NormalEquationsKernel* kernel) {
  // direct optimisation starts from theta0 and random thetas: a generator that errs does not lead it astray
  const Representation& representation = generator.representation();
  const Theta theta0(generator.theta0(), generator.theta0() + representation.thetaCount());
  const LevenbergMarquardtOptions polish = longLevenbergMarquardt(representation, options.levenberg_iterations);
  const FitResult direct = timedFit([&] { return fitDirect(representation, function, theta0, options, kernel); });
  // from the generator's theta, by both optimisers: a direct fit may miss the minimum beside it
  const auto adamPolicy = [&] {
    const FitResult adam =
        fitAdam(representation, function, start, refinementAdam(representation, directAdamSteps(representation, options)));
    return fitLevenbergMarquardt(representation, function, adam.theta, polish, kernel);
  };
  FitResult best = direct;
  double elapsed_us = direct.elapsed_us;
  for (const FitResult& other : {timedFit(adamPolicy), fitLevenbergMarquardt(representation, function, start, polish, kernel)}) {
    elapsed_us += other.elapsed_us;
    // a best that is not finite gives way to any other
    if (other.rmse < best.rmse || !std::isfinite(best.rmse)) best = other;
  }
  best.elapsed_us = elapsed_us;  // nobody knows the best before all have run
  return {direct, best};
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
  const WordMeters meters = wordMeters(set, options, kLongFitCount);
  Progress progress(std::string(representationName(representation)) + ": functions fitted", static_cast<int64_t>(sample.size()));
  std::mutex mutex;
  int64_t done = 0;
  parallelFor(sample.size(), options.threadCount(), [&](uint64_t n, int t) {
    WordMeter& thread = *meters[t];
    const uint64_t function = sample[n];
    const StoredFunction stored = storedFunction(set, function);
    // the seed is the function's own: sharing functions out among threads changes no fit
    DirectOptions direct = options.direct;
    direct.seed = startSeed(options, function);
    const std::array<FitResult, kLongFitCount> fits =
        fitLong(generator, decodeFunction(stored, pointOrder(representation), loss), starts[n], direct, &thread.kernel);
    // all of a function's fits are measured as the bake's thetas are: the same check, the same errors
    for (int f = 0; f < kLongFitCount; ++f) {
      const FunctionCheck check = thread.checker.check(representation, stored, fits[f].theta.data(), options.policy.check());
      const FunctionError error = thread.meter.measure(representation, fits[f].theta.data(), function);
      result.words[f].functions[n] = {function, error, !check.passes(options.policy.check()), true, fits[f].elapsed_us};
      thread.leaks[f].add(thread.meter.leakMagnitudes(), function, populations);
    }
    const std::lock_guard lock(mutex);
    progress.update(++done);
  });
  finishWords(meters, &result.words);
  return result;
}

}  // namespace nlg
