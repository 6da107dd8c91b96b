// The shared kernel against the machine's peak (machine/fma_peak in the same run).

#include <benchmark/benchmark.h>

#include "benchmarks/sample_function.h"
#include "runtime_eval/evaluator/evaluate.h"
#include "runtime_eval/fit/adam.h"
#include "runtime_eval/fit/network_loss.h"
#include "runtime_eval/fit/normal_equations.h"

namespace nlg {
namespace {

constexpr Representation kMlp = Representation::mlp(), kTentMlp = Representation::tentMlp();

void kernel(benchmark::State& state, const Representation& representation, int point_count) {
  const WeightingFunction function = wallFunction();
  const Theta theta = randomTheta({}, 1);
  Theta gradient(ThetaLayout::count);
  for (auto _ : state) {
    benchmark::DoNotOptimize(networkLossAndGradient(representation, stratifiedSupportPoints(), 0, point_count,
                                                    function.phi.data(), function.mask.data(), theta.data(), gradient.data()));
  }
  const double flop = 2.0 * kNetworkLossFmaPerPoint * point_count * static_cast<double>(state.iterations());
  state.counters["GFLOP/s"] = benchmark::Counter(1e-9 * flop, benchmark::Counter::kIsRate);
}
BENCHMARK_CAPTURE(kernel, mlp, kMlp, kSupportPointCount)->Name("loss_and_gradient/mlp/8192_points");
BENCHMARK_CAPTURE(kernel, tent_mlp, kTentMlp, kSupportPointCount)->Name("loss_and_gradient/tent_mlp/8192_points");
BENCHMARK_CAPTURE(kernel, stratum, kTentMlp, kStratumPointCount)->Name("loss_and_gradient/tent_mlp/1024_points");

void evaluatePoints(benchmark::State& state, const Representation& representation) {
  const Theta theta = randomTheta({}, 1);
  AlignedFloats values(kSupportPointCount);
  for (auto _ : state) {
    evaluate(representation, stratifiedSupportPoints(), theta.data(), values.data());
    benchmark::DoNotOptimize(values.data());
  }
}
BENCHMARK_CAPTURE(evaluatePoints, mlp, kMlp)->Name("evaluate/mlp/8192_points");
BENCHMARK_CAPTURE(evaluatePoints, tent_mlp, kTentMlp)->Name("evaluate/tent_mlp/8192_points");

void normalEquations(benchmark::State& state) {
  const WeightingFunction function = wallFunction();
  const Theta theta = randomTheta({}, 1);
  NormalEquationsKernel normal_kernel;
  NormalEquations equations;
  for (auto _ : state) normal_kernel.compute(kTentMlp, function, theta.data(), &equations);
}
BENCHMARK(normalEquations)->Name("normal_equations/tent_mlp/8192_points");

}  // namespace
}  // namespace nlg
