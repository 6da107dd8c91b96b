#include "validate/errors/convergence.h"

#include <algorithm>
#include <iterator>
#include <mutex>

#include "tool/parallel_for.h"
#include "tool/progress.h"
#include "validate/errors/statistics.h"

namespace nlg {
namespace {

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

Convergence measureConvergence(const Generator& generator, const FunctionSet& set, const Populations& populations,
                               const LongFits& fits, const ValidateOptions& options) {
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
  Convergence result;
  result.functions = functions.size();
  if (functions.empty()) return result;
  const auto meanAt = [&](std::vector<double> FunctionCurves::*curve, size_t i) {
    std::vector<double> errors;
    for (const FunctionCurves& one : curves) errors.push_back((one.*curve)[i]);
    return mean(errors);
  };
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
