// Generator inference end to end, stored samples in, theta out: K = 512, 6 layers of 512, the numbers random.

#include <benchmark/benchmark.h>

#include <cmath>

#include "runtime_eval/evaluator/generator.h"
#include "runtime_eval/support/random.h"

namespace nlg {
namespace {

constexpr int kWidth = 512, kLayerCount = 6;

void fillNormal(std::vector<float>& values, size_t count, double deviation, Random& random) {
  values.resize(count);
  for (float& value : values) value = static_cast<float>(deviation * random.normal());
}

GeneratorData randomGenerator() {
  Random random(1);
  GeneratorData data;
  data.basis.class_count = {126, 82, 81, 42, 81, 42, 42, 16};  // as real bases fall out
  fillNormal(data.basis.mean, kSupportPointCount, 0.1, random);
  fillNormal(data.basis.components, size_t{kWidth} * kOctantPointCount, 1.0 / 32, random);
  data.basis.deviation.assign(kWidth, 1.0f);
  for (int l = 0; l < kLayerCount; ++l) {
    GeneratorLayer layer{kWidth, l + 1 == kLayerCount ? ThetaLayout::count : kWidth, {}, {}};
    fillNormal(layer.weight, size_t(layer.input_count) * layer.output_count, 1.0 / std::sqrt(kWidth), random);
    fillNormal(layer.bias, layer.output_count, 0.1, random);
    data.layers.push_back(std::move(layer));
  }
  data.theta0.assign(ThetaLayout::count, 0.0f);
  data.output_scale.assign(ThetaLayout::count, 1.0f);
  return data;
}

void generate(benchmark::State& state) {
  const Generator generator(randomGenerator());
  GeneratorScratch scratch(generator);
  const int count = static_cast<int>(state.range(0));
  std::vector<uint8_t> phi(size_t(count) * kSupportPointCount);
  Random random(2);
  for (uint8_t& sample : phi) sample = static_cast<uint8_t>(random.next() >> 24);
  std::vector<float> theta(size_t(count) * ThetaLayout::count);
  for (auto _ : state) generator.generate(phi.data(), count, theta.data(), &scratch);
  const double functions = static_cast<double>(count) * static_cast<double>(state.iterations());
  const double fma = kWidth * kOctantPointCount + (kLayerCount - 1.0) * kWidth * kWidth + kWidth * ThetaLayout::count;
  state.counters["functions/s"] = benchmark::Counter(functions, benchmark::Counter::kIsRate);
  state.counters["GFLOP/s"] = benchmark::Counter(2e-9 * fma * functions, benchmark::Counter::kIsRate);
}
BENCHMARK(generate)->Name("generator/float32/batch")->Arg(1)->Arg(96)->Arg(960);

}  // namespace
}  // namespace nlg
