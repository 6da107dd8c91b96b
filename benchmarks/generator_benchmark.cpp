// Generator inference end to end and its parts, on the best target and on forced ones.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>

#include "benchmarks/fma_peak.h"
#include "benchmarks/random_generator.h"
#include "runtime_eval/simd/simd_target.h"

namespace nlg {
namespace {

// Seconds of this thread's own: a shared machine takes time away, not work.
double threadSeconds() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

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
void measure(benchmark::State& state, const char* simd, double functions, double products, const Work& work) {
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
  if (products > 0.0) {
    state.counters["GFLOP/s"] = 2e-9 * products * rate;
    state.counters["of_fma_peak"] = 2e-9 * products * rate / peak;
  }
  forceSimdTarget("");
}

template <class Sample>
void generateSamples(benchmark::State& state, GeneratorPrecision precision, const char* simd) {
  const Generator generator(randomGenerator(), precision);
  GeneratorScratch scratch(generator);
  const int count = static_cast<int>(state.range(0));
  const std::vector<uint8_t> bytes = randomBytes(size_t(count) * kSupportPointCount);
  std::vector<Sample> phi(bytes.begin(), bytes.end());
  if (sizeof(Sample) > 1)
    std::transform(phi.begin(), phi.end(), phi.begin(), [](Sample s) { return static_cast<Sample>(s / 255.0f); });
  std::vector<float> theta(size_t(count) * ThetaLayout::count);
  measure(state, simd, count, kBenchmarkProducts, [&] { generator.generate(phi.data(), count, theta.data(), &scratch); });
}
void generate(benchmark::State& state, GeneratorPrecision precision, const char* simd) {
  generateSamples<uint8_t>(state, precision, simd);
}
void generateFloats(benchmark::State& state, GeneratorPrecision precision) { generateSamples<float>(state, precision, ""); }
constexpr GeneratorPrecision kFloat = GeneratorPrecision::float32, kInteger = GeneratorPrecision::int16;
BENCHMARK_CAPTURE(generate, float32, kFloat, "")->Name("generator/float32/batch")->Arg(1)->Arg(96)->Arg(960);
BENCHMARK_CAPTURE(generate, int16, kInteger, "")->Name("generator/int16/batch")->Arg(1)->Arg(96)->Arg(960);
BENCHMARK_CAPTURE(generateFloats, float32, kFloat)->Name("generator/float32/float_samples")->Arg(96);
BENCHMARK_CAPTURE(generateFloats, int16, kInteger)->Name("generator/int16/float_samples")->Arg(96);
BENCHMARK_CAPTURE(generate, float32_avx512, kFloat, "avx512")->Name("generator/float32/avx512")->Arg(96);
BENCHMARK_CAPTURE(generate, float32_avx2, kFloat, "avx2")->Name("generator/float32/avx2")->Arg(96);
BENCHMARK_CAPTURE(generate, float32_sse4, kFloat, "sse4")->Name("generator/float32/sse4")->Arg(96);
BENCHMARK_CAPTURE(generate, int16_avx512, kInteger, "avx512")->Name("generator/int16/avx512")->Arg(96);
BENCHMARK_CAPTURE(generate, int16_avx2, kInteger, "avx2")->Name("generator/int16/avx2")->Arg(96);
BENCHMARK_CAPTURE(generate, int16_sse4, kInteger, "sse4")->Name("generator/int16/sse4")->Arg(96);

// The parts of a batch of 96.
template <class Class>
void transform(benchmark::State& state) {
  const std::vector<uint8_t> phi = randomBytes(size_t(kBatchCount) * kSupportPointCount);
  std::vector<Class, CacheLineAllocator<Class>> classes(size_t(kBatchCount) * kClassStride);
  measure(state, "", kBatchCount, 0.0, [&] { parityTransform(phi.data(), kBatchCount, classes.data()); });
}
BENCHMARK(transform<float>)->Name("generator/parts/transform_to_float32");
BENCHMARK(transform<int16_t>)->Name("generator/parts/transform_to_int16");

void project(benchmark::State& state, GeneratorPrecision precision) {
  const Projection projection(randomGenerator().basis, precision);
  ProjectionScratch scratch(precision);
  const std::vector<uint8_t> phi = randomBytes(size_t(kBatchCount) * kSupportPointCount);
  AlignedFloats coefficients(size_t(kBatchCount) * kBenchmarkWidth);
  measure(state, "", kBatchCount, double{kBenchmarkWidth} * kOctantPointCount,
          [&] { projection.project(phi.data(), kBatchCount, coefficients.data(), &scratch); });
}
BENCHMARK_CAPTURE(project, float32, kFloat)->Name("generator/parts/transform_and_projection_float32");
BENCHMARK_CAPTURE(project, int16, kInteger)->Name("generator/parts/transform_and_projection_int16");

void layer(benchmark::State& state, GeneratorPrecision precision) {
  const GeneratorLayer layer = randomGenerator().layers[1];
  const PackedMatrix float_matrix(layer.weight.data(), kBenchmarkWidth, kBenchmarkWidth);
  const PackedIntegerMatrix integer_matrix(layer.weight.data(), kBenchmarkWidth, kBenchmarkWidth, kActivationLimit);
  Random random(3);
  const std::vector<float> values = normalValues(size_t(kBatchCount) * kBenchmarkWidth, 1.0, random);
  const AlignedFloats input(values.begin(), values.end());
  AlignedFloats output(input.size()), scales(kBatchCount);
  constexpr int kStride = kBenchmarkWidth + 32;
  AlignedIntegers integers(size_t(kBatchCount) * kStride);
  measure(state, "", kBatchCount, double{kBenchmarkWidth} * kBenchmarkWidth, [&] {
    if (precision == kFloat) {
      multiply({input.data(), kBenchmarkWidth}, kBatchCount, float_matrix, layer.bias.data(), Epilogue::leaky_and_skip, 0.01f,
               output.data(), kBenchmarkWidth);
    } else {
      quantiseRows(input.data(), kBatchCount, kBenchmarkWidth, integers.data(), kStride, scales.data());
      multiply({integers.data(), kStride, scales.data()}, kBatchCount, integer_matrix, layer.bias.data(),
               Epilogue::leaky_and_skip, 0.01f, input.data(), output.data(), kBenchmarkWidth);
    }
  });
}
BENCHMARK_CAPTURE(layer, float32, kFloat)->Name("generator/parts/layer_float32");
BENCHMARK_CAPTURE(layer, int16, kInteger)->Name("generator/parts/layer_int16");

}  // namespace
}  // namespace nlg
