#include "validate/errors/measured_word.h"

#include <cmath>

#include "tool/error.h"
#include "tool/parallel_for.h"

namespace nlg {

void PopulationLeaks::add(const std::vector<double>& magnitudes, uint64_t function, const Populations& populations) {
  for (int s = 0; s < kScopeCount; ++s) {
    for (int p = 0; p < kPopulationCount; ++p) {
      const auto scope = static_cast<Scope>(s);
      const auto population = static_cast<Population>(p);
      if (populations.contains(scope, population, function)) pools_[index(scope, population)].add(magnitudes);
    }
  }
}

void PopulationLeaks::add(const PopulationLeaks& other) {
  for (size_t i = 0; i < pools_.size(); ++i) pools_[i].add(other.pools_[i]);
}

void MeasuredWord::mustBeFinite() const {
  for (const MeasuredFunction& one : functions) {
    for (const double rmse : {one.error.blend_rmse, one.error.rmse, one.error.rmse_test_points}) {
      if (!std::isfinite(rmse))
        throw NumericalError("validate", "function " + std::to_string(one.function), name + ": RMSE", rmse);
    }
  }
}

MeasuredWord measureTents(const FunctionSet& set, const Populations& populations, const ValidateOptions& options) {
  struct Thread {
    Thread(const FunctionSet& set, const LossOptions& loss) : meter(set, loss) {}
    ErrorMeter meter;
    FunctionChecker checker;
    PopulationLeaks leaks;
  };
  MeasuredWord word{"tent", std::vector<MeasuredFunction>(set.functionCount()), {}};
  std::vector<Thread> threads(options.threadCount(), Thread(set, options.policy.check().loss()));
  parallelFor(set.functionCount(), options.threadCount(), [&](uint64_t i, int t) {
    Thread& thread = threads[t];
    const FunctionCheck check = thread.checker.checkBareTent(storedFunction(set, i), options.policy.check());
    word.functions[i] = {i, thread.meter.measureTent(i), !check.passes(options.policy.check()), false, 0.0};
    thread.leaks.add(thread.meter.leakMagnitudes(), i, populations);
  });
  for (const Thread& thread : threads) word.leaks.add(thread.leaks);
  return word;
}

}  // namespace nlg
