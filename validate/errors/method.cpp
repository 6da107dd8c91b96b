#include "validate/errors/method.h"

#include "runtime_eval/numbers/random.h"
#include "tool/error.h"
#include "tool/parallel_for.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>

namespace nlg {
namespace {

using Clock = std::chrono::steady_clock;

double microsecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

int threadCount(const ValidateOptions& options) { return options.threads > 0 ? options.threads : machineThreadCount(); }

// One fit of one function: what it is called, and theta from the function.
struct TimedFit {
  int method;
  Theta theta;
  double elapsed_us;
};

enum Fit { kRefinedAdam, kRefinedLm, kDirect, kAdamTheta0, kLmTheta0, kAdamRandom, kFitCount };
constexpr const char* kFitNames[kFitCount] = {"refined_adam", "refined_lm", "direct", "adam_theta0", "lm_theta0", "adam_random"};

std::vector<TimedFit> fitAll(const Generator& generator, const StoredFunction& stored, const Theta& generated,
                             const ValidateOptions& options, uint64_t seed, NormalEquationsKernel* kernel) {
  const Representation& representation = generator.representation();
  const Theta theta0(generator.theta0(), generator.theta0() + representation.thetaCount());
  const Clock::time_point start = Clock::now();
  const WeightingFunction function = decodeFunction(stored, pointOrder(representation));
  const double decode_us = microsecondsSince(start);
  std::vector<TimedFit> fits;
  const auto add = [&](int method, const FitResult& fit) { fits.push_back({method, fit.theta, decode_us + fit.elapsed_us}); };
  add(kRefinedAdam, fitAdam(representation, function, generated, refinementAdam(representation, options.adam_refine_steps)));
  add(kRefinedLm, fitLevenbergMarquardt(representation, function, generated,
                                        refinementLevenbergMarquardt(representation, options.lm_refine_iterations), kernel));
  DirectOptions direct_options = options.direct;
  direct_options.seed = seed;
  const Clock::time_point direct_start = Clock::now();
  const DirectResult direct = fitDirect(representation, function, theta0, direct_options, kernel);
  const double direct_us = microsecondsSince(direct_start);
  fits.push_back({kDirect, direct.best.theta, decode_us + direct_us});
  add(kAdamTheta0, direct.adam_from_theta0);
  add(kLmTheta0, direct.levenberg_from_theta0);
  add(kAdamRandom, direct.adam_from_random);
  return fits;
}

}  // namespace

bool needsRefinement(const FunctionError& error, const ValidateOptions& options) {
  return error.rmse > options.refinement.check.tau_rmse || error.leak_p99 > options.refinement.check.tau_leak;
}

MethodResult measureTent(const FunctionSet& set) {
  MethodResult result{"tent"};
  ErrorMeter meter(set);
  for (uint64_t i = 0; i < set.functionCount(); ++i) result.samples.push_back({i, meter.measureTent(i, &result.leaks)});
  return result;
}

double measureEvaluation(const Representation& representation, const float* theta) {
  const PointSet points = makePointSet(supportPattern().points);
  AlignedFloats values(points.padded_count);
  std::vector<double> elapsed_us(201);  // the median leaves out the first, on cold caches, and whatever is interrupted
  for (double& elapsed : elapsed_us) {
    const Clock::time_point start = Clock::now();
    evaluate(representation, points, theta, values.data());
    elapsed = microsecondsSince(start);
  }
  return quantile(elapsed_us, 0.5);
}

MethodResult measureUncorrected(const Generator& generator, const FunctionSet& set, std::vector<float>* theta) {
  MethodResult result{"uncorrected"};
  ErrorMeter meter(set);
  GeneratorScratch scratch(generator);
  const uint64_t count = set.functionCount();
  const auto D = static_cast<uint64_t>(generator.representation().thetaCount());
  theta->resize(count * D);
  for (uint64_t begin = 0; begin < count; begin += kBatchCount) {
    const int batch = static_cast<int>(std::min<uint64_t>(kBatchCount, count - begin));
    const Clock::time_point start = Clock::now();
    generator.generate(&set.phi[begin * kSupportPointCount], batch, theta->data() + begin * D, &scratch);
    const double elapsed_us = microsecondsSince(start) / batch;
    for (uint64_t i = begin * D; i < (begin + batch) * D; ++i) {
      if (!std::isfinite((*theta)[i])) {
        throw NumericalError("validate", "function " + std::to_string(i / D), "generated theta", (*theta)[i]);
      }
    }
    for (uint64_t i = begin; i < begin + batch; ++i) {
      const FunctionError error = meter.measure(generator.representation(), theta->data() + i * D, i, &result.leaks);
      result.samples.push_back({i, error, elapsed_us});
    }
  }
  return result;
}

MethodResult measureGenerator(const Generator& generator, const FunctionSet& set, const MethodResult& uncorrected,
                              const CorrectionOptions& options, std::vector<float>* theta) {
  MethodResult result{"generator"};
  ErrorMeter meter(set);
  Corrector corrector(generator, options);
  const uint64_t count = set.functionCount();
  const auto D = static_cast<uint64_t>(generator.representation().thetaCount());
  for (uint64_t begin = 0; begin < count; begin += kBatchCount) {
    std::vector<StoredFunction> functions;
    for (uint64_t i = begin; i < std::min<uint64_t>(begin + kBatchCount, count); ++i) functions.push_back(storedFunction(set, i));
    const int batch = static_cast<int>(functions.size());
    const Clock::time_point start = Clock::now();
    corrector.correct(functions.data(), batch, theta->data() + begin * D);
    const double elapsed_us = microsecondsSince(start) / batch;
    for (uint64_t i = begin; i < begin + functions.size(); ++i) {
      const FunctionError error = meter.measure(generator.representation(), theta->data() + i * D, i, &result.leaks);
      result.samples.push_back({i, error, uncorrected.samples[i].elapsed_us + elapsed_us});
    }
  }
  return result;
}

MethodResult measurePolicy(const Generator& generator, const FunctionSet& set, const MethodResult& generated,
                           const std::vector<float>& theta, const ValidateOptions& options) {
  MethodResult result{"refined", generated.samples, {}};
  std::mutex mutex;
  const Representation& representation = generator.representation();
  const auto D = static_cast<uint64_t>(representation.thetaCount());
  const Theta theta0(generator.theta0(), generator.theta0() + D);
  const uint64_t chunk = 64, count = result.samples.size();
  parallelFor((count + chunk - 1) / chunk, threadCount(options), [&](uint64_t c, int) {
    ErrorMeter meter(set);
    FunctionChecker checker;
    Refiner refiner;
    PooledMagnitudes leaks;
    for (uint64_t i = c * chunk; i < std::min(count, (c + 1) * chunk); ++i) {
      MethodSample& sample = result.samples[i];
      Theta fitted(&theta[i * D], &theta[i * D] + D);
      const StoredFunction stored = storedFunction(set, sample.function);
      const Clock::time_point begin = Clock::now();
      const FunctionCheck check = checker.check(representation, stored, fitted.data(), options.refinement.check);
      sample.refined = !check.passes(options.refinement.check);
      if (sample.refined) fitted = refiner.refine(representation, stored, fitted, theta0, options.refinement).theta;
      sample.elapsed_us += microsecondsSince(begin);
      sample.error = meter.measure(representation, fitted.data(), sample.function, &leaks);
    }
    const std::lock_guard lock(mutex);
    result.leaks.add(leaks);
  });
  return result;
}

std::vector<MethodResult> measureFits(const Generator& generator, const FunctionSet& set, const std::vector<uint64_t>& functions,
                                      const std::vector<float>& theta, const ValidateOptions& options,
                                      const std::function<void(int64_t done)>& progress) {
  std::vector<MethodResult> results(kFitCount);
  for (int m = 0; m < kFitCount; ++m) {
    results[m].name = kFitNames[m];
    results[m].samples.resize(functions.size());
  }
  const auto D = static_cast<uint64_t>(generator.representation().thetaCount());
  std::mutex mutex;
  int64_t done = 0;
  parallelFor(functions.size(), threadCount(options), [&](uint64_t i, int) {
    NormalEquationsKernel kernel;
    ErrorMeter meter(set);
    const Theta generated(&theta[functions[i] * D], &theta[functions[i] * D] + D);
    const std::vector<TimedFit> fits =
        fitAll(generator, storedFunction(set, functions[i]), generated, options, mixSeed(options.seed, functions[i]), &kernel);
    const std::lock_guard lock(mutex);
    for (const TimedFit& fit : fits) {
      MethodResult& result = results[fit.method];
      const FunctionError error = meter.measure(generator.representation(), fit.theta.data(), functions[i], &result.leaks);
      result.samples[i] = {functions[i], error, fit.elapsed_us};
    }
    progress(++done);
  });
  return results;
}

}  // namespace nlg
