// The generator beside libtorch on the same work, one thread each.
//
// libtorch gets what helps it: scales folded into its weights, one product for the whole basis, inference mode. OpenBLAS needs
// OPENBLAS_CORETYPE=SkylakeX where it does not know the machine.

#include <benchmark/benchmark.h>
#include <torch/torch.h>

#include <cmath>

#include "benchmarks/random_generator.h"

namespace nlg {
namespace {

constexpr int kPeerBatch = 256;

void useOneThread() {
  static const bool once = [] {
    torch::set_num_threads(1);
    return true;
  }();
  benchmark::DoNotOptimize(once);
}

void countFunctions(benchmark::State& state, double functions) {
  state.counters["functions/s"] =
      benchmark::Counter(functions * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}

// The generator as a chain of libtorch's products.
struct TorchGenerator {
  torch::Tensor basis, basis_bias;  // 8192 x K, K
  std::vector<torch::Tensor> weights, biases;
  double slope;

  explicit TorchGenerator(const GeneratorData& data) : slope(data.slope) {
    const int64_t count = data.basis.coefficientCount();
    basis = torch::zeros({kSupportPointCount, count});
    basis_bias = torch::zeros({count});
    auto dense = basis.accessor<float, 2>();
    for (int64_t k = 0, c = 0, in_class = 0; k < count; ++k, ++in_class) {
      while (in_class == data.basis.class_count[c]) ++c, in_class = 0;
      const float* component = &data.basis.components[size_t(k) * kOctantPointCount];
      double mean = 0.0;
      for (int i = 0; i < kOctantPointCount; ++i) mean += double{data.basis.mean[c * kOctantPointCount + i]} * component[i];
      basis_bias[k] = -mean / data.basis.deviation[k];
      for (int p = 0; p < kSupportPointCount; ++p) {
        const double sign = mirrorSign(static_cast<int>(c), p / kOctantPointCount);
        dense[p][k] =
            static_cast<float>(sign * component[p % kOctantPointCount] / (255.0 * std::sqrt(8.0) * data.basis.deviation[k]));
      }
    }
    for (const GeneratorLayer& layer : data.layers) {
      weights.push_back(torch::tensor(layer.weight).view({layer.output_count, layer.input_count}).t().contiguous());
      biases.push_back(torch::tensor(layer.bias));
    }
    // folded into the last layer
    const torch::Tensor output_scale = torch::tensor(data.output_scale);
    weights.back() = weights.back() * output_scale;
    biases.back() = biases.back() * output_scale + torch::tensor(data.theta0);
  }

  // phi: N x 8192 bytes
  torch::Tensor forward(const torch::Tensor& phi) const {
    torch::Tensor values = torch::addmm(basis_bias, phi.to(torch::kFloat32), basis);
    for (size_t l = 0; l + 1 < weights.size(); ++l) {
      torch::Tensor hidden = torch::leaky_relu(torch::addmm(biases[l], values, weights[l]), slope);
      values = hidden.size(1) == values.size(1) ? hidden.add_(values) : hidden;
    }
    return torch::addmm(biases.back(), values, weights.back());
  }
};

void generateByTorch(benchmark::State& state) {
  useOneThread();
  const torch::InferenceMode guard;
  const GeneratorData data = randomGenerator();
  const TorchGenerator peer(data);
  std::vector<uint8_t> phi = randomBytes(size_t{kPeerBatch} * kSupportPointCount);
  const torch::Tensor input = torch::from_blob(phi.data(), {kPeerBatch, kSupportPointCount}, torch::kUInt8);
  torch::Tensor theta;
  for (auto _ : state) theta = peer.forward(input);
  countFunctions(state, kPeerBatch);
  // both compute the same
  const Generator generator(data);
  GeneratorScratch scratch(generator);
  torch::Tensor own = torch::empty_like(theta);
  const std::vector<StoredFunction> functions = validFunctions(phi);
  generator.generate(functions.data(), kPeerBatch, own.data_ptr<float>(), &scratch);
  state.counters["difference/theta"] = ((own - theta).norm() / theta.norm()).item<double>();
}
BENCHMARK(generateByTorch)->Name("peer/generator/libtorch_float32")->Unit(benchmark::kMillisecond);

void generateByUs(benchmark::State& state) {
  const Generator generator(randomGenerator());
  GeneratorScratch scratch(generator);
  const std::vector<uint8_t> phi = randomBytes(size_t{kPeerBatch} * kSupportPointCount);
  std::vector<float> theta(size_t{kPeerBatch} * ThetaLayout::count);
  const std::vector<StoredFunction> functions = validFunctions(phi);
  for (auto _ : state) generator.generate(functions.data(), kPeerBatch, theta.data(), &scratch);
  countFunctions(state, kPeerBatch);
}
BENCHMARK(generateByUs)->Name("peer/generator/ours_float32")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace nlg
