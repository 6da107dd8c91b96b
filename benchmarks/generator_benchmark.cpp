// Generator inference end to end, on the best target and on forced ones.

#include <benchmark/benchmark.h>

#include <algorithm>

#include "benchmarks/fma_peak.h"
#include "benchmarks/random_generator.h"
#include "nlg/simd.h"
#include "tool/processor_time.h"

namespace nlg {
namespace {

// GFLOP/s of fused multiply-adds on registers, the best of some milliseconds, on the target in use.
double measuredPeak() {
  double best = 0.0;
  for (int round = 0; round < 20; ++round) {
    const double begin = threadSeconds(), count = runFusedMultiplyAdds(20000);
    best = std::max(best, 2e-9 * count / (threadSeconds() - begin));
  }
  return best;
}

// Runs `work` on a SIMD target and reports the rate of its multiply-adds beside the float32 peak of the same moment.
template <class Work>
void measure(benchmark::State& state, const char* simd, double functions, const Work& work) {
  if (forceSimdTarget(simd) != SimdStatus::ok) {
    state.SkipWithError("this machine does not have the target");
    return;
  }
  double peak = measuredPeak();
  const double begin = threadSeconds();
  for (auto _ : state) work();
  const double elapsed = threadSeconds() - begin;
  peak = std::max(peak, measuredPeak());
  const double rate = functions * static_cast<double>(state.iterations()) / elapsed;
  state.counters["functions/s"] = rate;
  state.counters["GFLOP/s"] = 2e-9 * kBenchmarkProducts * rate;
  state.counters["of_fma_peak"] = 2e-9 * kBenchmarkProducts * rate / peak;
  forceSimdTarget("");
}

void generate(benchmark::State& state, const char* simd) {
  const Generator generator(randomGenerator());
  GeneratorScratch scratch(generator);
  const int count = static_cast<int>(state.range(0));
  const std::vector<uint8_t> phi = randomBytes(size_t(count) * kSupportPointCount);
  const std::vector<StoredFunction> functions = validFunctions(phi);
  std::vector<float> theta(size_t(count) * ThetaLayout::count);
  measure(state, simd, count, [&] { generator.generate(functions.data(), count, theta.data(), &scratch); });
}
BENCHMARK_CAPTURE(generate, best, "")->Name("generator/float32/batch")->Arg(1)->Arg(96)->Arg(960);
BENCHMARK_CAPTURE(generate, avx512, "avx512")->Name("generator/float32/avx512")->Arg(96);
BENCHMARK_CAPTURE(generate, avx2, "avx2")->Name("generator/float32/avx2")->Arg(96);
BENCHMARK_CAPTURE(generate, sse4, "sse4")->Name("generator/float32/sse4")->Arg(96);

}  // namespace
}  // namespace nlg
