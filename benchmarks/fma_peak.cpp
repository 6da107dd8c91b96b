#include "benchmarks/fma_peak.h"

#include <benchmark/benchmark.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "benchmarks/fma_peak.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

double fusedMultiplyAdds(int rounds) {
  const hn::CappedTag<float, 16> d;
  // twelve chains hide the latency of four cycles on two units, and leave registers for the operands
  constexpr int kChains = 12;
  hn::Vec<decltype(d)> sum[kChains];
  for (int i = 0; i < kChains; ++i) sum[i] = hn::Set(d, 1.0f + static_cast<float>(i));
  const auto factor = hn::Set(d, 0.999f), addend = hn::Set(d, 0.001f);
  for (int round = 0; round < rounds; ++round) {
#pragma GCC unroll 12
    for (int i = 0; i < kChains; ++i) sum[i] = hn::MulAdd(sum[i], factor, addend);
  }
  auto total = sum[0];
  for (int i = 1; i < kChains; ++i) total = hn::Add(total, sum[i]);
  benchmark::DoNotOptimize(hn::GetLane(hn::SumOfLanes(d, total)));
  return static_cast<double>(rounds) * kChains * static_cast<double>(hn::Lanes(d));
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(fusedMultiplyAdds);

double runFusedMultiplyAdds(int rounds) { return HWY_DYNAMIC_DISPATCH(fusedMultiplyAdds)(rounds); }

namespace {

void peak(benchmark::State& state) {
  double count = 0.0;
  for (auto _ : state) count += runFusedMultiplyAdds(10000);
  state.counters["GFLOP/s"] = benchmark::Counter(2e-9 * count, benchmark::Counter::kIsRate);
}
BENCHMARK(peak)->Name("machine/fma_peak/registers");

}  // namespace
}  // namespace nlg
#endif  // HWY_ONCE
