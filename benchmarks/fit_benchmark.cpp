// Fits of one function from theta0 at fixed budgets, with the error that they reach.

#include <benchmark/benchmark.h>

#include "benchmarks/sample_function.h"
#include "runtime_eval/fit/direct.h"

namespace nlg {
namespace {

const Theta& start(const Representation& representation) {
  static NormalEquationsKernel kernel;
  static const Theta mlp = fitStart(Representation::mlp(), tentFunction(), {}, &kernel).theta;
  static const Theta tent_mlp = fitStart(Representation::tentMlp(), tentFunction(), {}, &kernel).theta;
  return representation.tentFactor() ? tent_mlp : mlp;
}

void adam(benchmark::State& state, const Representation& representation, bool eigenbasis) {
  const WeightingFunction function = wallFunction();
  AdamOptions options = refinementAdam(representation, static_cast<int>(state.range(0)));
  options.eigenbasis = eigenbasis;
  const Theta& theta = start(representation);
  FitResult fit;
  for (auto _ : state) fit = fitAdam(representation, function, theta, options);
  state.counters["rmse"] = fit.rmse;
}
BENCHMARK_CAPTURE(adam, mlp, Representation::mlp(), true)
    ->Name("fit/adam/mlp")
    ->Arg(200)
    ->Arg(2000)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(adam, tent_mlp, Representation::tentMlp(), true)
    ->Name("fit/adam/tent_mlp")
    ->Arg(200)
    ->Arg(2000)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(adam, plain_tent_mlp, Representation::tentMlp(), false)
    ->Name("fit/plain_adam/tent_mlp")
    ->Arg(200)
    ->Arg(2000)
    ->Unit(benchmark::kMillisecond);

void levenbergMarquardt(benchmark::State& state, const Representation& representation) {
  const WeightingFunction function = wallFunction();
  NormalEquationsKernel kernel;
  const Theta& theta = start(representation);
  FitResult fit;
  for (auto _ : state) {
    fit = fitLevenbergMarquardt(representation, function, theta, {.iterations = static_cast<int>(state.range(0))}, &kernel);
  }
  state.counters["rmse"] = fit.rmse;
}
BENCHMARK_CAPTURE(levenbergMarquardt, mlp, Representation::mlp())
    ->Name("fit/lm/mlp")
    ->Arg(8)
    ->Arg(40)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(levenbergMarquardt, tent_mlp, Representation::tentMlp())
    ->Name("fit/lm/tent_mlp")
    ->Arg(8)
    ->Arg(40)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace nlg
