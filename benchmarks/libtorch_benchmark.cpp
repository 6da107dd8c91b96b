// Our kernels beside libtorch on the same work, one thread each: the generator, and Adam on tiny networks; and how far the two
// generators are apart on exported weights.
//
// libtorch gets what helps it: scales folded into its weights, one product for the whole basis, inference mode, and functions
// batched 256 at a time in its second form of Adam. OpenBLAS needs OPENBLAS_CORETYPE=SkylakeX where it does not know the machine.

#include <benchmark/benchmark.h>
#include <torch/torch.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "benchmarks/random_generator.h"
#include "benchmarks/sample_function.h"
#include "datagen/dataset/function_set.h"
#include "runtime_eval/evaluator/evaluate.h"
#include "runtime_eval/fit/adam.h"

namespace nlg {
namespace {

constexpr int kPeerBatch = 256, kAdamSteps = 500;
constexpr double kAdamRate = 0.01;

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
  generator.generate(phi.data(), kPeerBatch, own.data_ptr<float>(), &scratch);
  state.counters["difference/theta"] = ((own - theta).norm() / theta.norm()).item<double>();
}
BENCHMARK(generateByTorch)->Name("peer/generator/libtorch_float32")->Unit(benchmark::kMillisecond);

void generateByUs(benchmark::State& state, GeneratorPrecision precision) {
  const Generator generator(randomGenerator(), precision);
  GeneratorScratch scratch(generator);
  const std::vector<uint8_t> phi = randomBytes(size_t{kPeerBatch} * kSupportPointCount);
  std::vector<float> theta(size_t{kPeerBatch} * ThetaLayout::count);
  for (auto _ : state) generator.generate(phi.data(), kPeerBatch, theta.data(), &scratch);
  countFunctions(state, kPeerBatch);
}
BENCHMARK_CAPTURE(generateByUs, float32, GeneratorPrecision::float32)
    ->Name("peer/generator/ours_float32")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(generateByUs, int16, GeneratorPrecision::int16)
    ->Name("peer/generator/ours_int16")
    ->Unit(benchmark::kMillisecond);

constexpr int kParityFunctionCount = 10000;

// Files of a folder that an environment variable names, by their ending; none when it is not set.
std::vector<std::string> filesOf(const char* variable, const char* ending) {
  std::vector<std::string> paths;
  const char* folder = std::getenv(variable);
  if (folder == nullptr) return paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ending) paths.push_back(entry.path().string());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

// Stored functions at equal distances of all shards in the folder NLG_SHARDS; walls without it.
std::vector<uint8_t> parityFunctions() {
  std::vector<uint8_t> phi, validity;
  const std::vector<std::string> shards = filesOf("NLG_SHARDS", ".h5");
  if (shards.empty()) {
    appendStoredWalls(kParityFunctionCount, &phi, &validity);
    return phi;
  }
  const FunctionSet set = readFunctionSet(shards, supportPattern().hash, kSupportPointCount);
  const auto count = static_cast<int64_t>(std::min<uint64_t>(kParityFunctionCount, set.functionCount()));
  for (int64_t i = 0; i < count; ++i) {
    const auto first = set.phi.begin() + i * static_cast<int64_t>(set.functionCount()) / count * kSupportPointCount;
    phi.insert(phi.end(), first, first + kSupportPointCount);
  }
  return phi;
}

// Largest difference between the evaluator and libtorch on exported weights, of theta and of what it stands for.
void differ(benchmark::State& state, const std::string& path) {
  useOneThread();
  const torch::InferenceMode guard;
  WeightsFile file;
  GeneratorData data;
  FileResult result = readWeightsFile(path, &file);
  if (result.ok()) result = generatorFromWeights(file, &data);
  if (!result.ok()) return state.SkipWithError(result.detail.c_str());
  std::vector<uint8_t> phi = parityFunctions();
  const auto count = static_cast<int64_t>(phi.size() / kSupportPointCount);
  const int theta_count = data.representation.thetaCount();
  const TorchGenerator peer(data);
  const Generator generator(data);
  GeneratorScratch scratch(generator);
  const PointSet& points = stratifiedSupportPoints();
  AlignedFloats own_values(points.padded_count), peer_values(points.padded_count);
  double theta_difference = 0.0, output_difference = 0.0;
  const auto raise = [](double& largest, double value) {
    if (!(value <= largest)) largest = value;  // a NaN stays
  };
  for (auto _ : state) {
    for (int64_t first = 0; first < count; first += kPeerBatch) {
      const int64_t batch = std::min<int64_t>(kPeerBatch, count - first);
      uint8_t* samples = &phi[size_t(first) * kSupportPointCount];
      const torch::Tensor peer_theta =
          peer.forward(torch::from_blob(samples, {batch, kSupportPointCount}, torch::kUInt8)).contiguous();
      std::vector<float> own_theta(size_t(batch) * theta_count);
      generator.generate(samples, static_cast<int>(batch), own_theta.data(), &scratch);
      for (int64_t i = 0; i < batch * theta_count; ++i) {
        raise(theta_difference, std::fabs(double{own_theta[i]} - peer_theta.data_ptr<float>()[i]));
      }
      for (int64_t b = 0; b < batch; ++b) {
        evaluate(data.representation, points, &own_theta[size_t(b) * theta_count], own_values.data());
        evaluate(data.representation, points, peer_theta.data_ptr<float>() + b * theta_count, peer_values.data());
        for (int p = 0; p < points.count; ++p) raise(output_difference, std::fabs(double{own_values[p]} - peer_values[p]));
      }
    }
  }
  state.counters["functions"] = static_cast<double>(count);
  state.counters["largest_theta"] = theta_difference;
  state.counters["largest_output"] = output_difference;
}

// One case a file of the folder NLG_WEIGHTS.
const bool kDifferencesAreRegistered = [] {
  for (const std::string& path : filesOf("NLG_WEIGHTS", ".safetensors")) {
    const std::string name = "peer/difference/" + std::filesystem::path(path).stem().string();
    benchmark::RegisterBenchmark(name.c_str(), [path](benchmark::State& state) { differ(state, path); })
        ->Iterations(1)
        ->Unit(benchmark::kMillisecond);
  }
  return true;
}();

// `count` copies of the tiny network, points along the last axis: x 1 x 3 x P, values count x 1 x P.
struct TorchNetworks {
  torch::Tensor w1, b1, w2, b2, w3, b3;

  explicit TorchNetworks(int64_t count) {
    const Theta start = randomTheta(Representation::mlp(), 1);
    const auto part = [&](int first, int64_t rows, int64_t columns) {
      const std::vector<float> values(start.begin() + first, start.begin() + first + rows * columns);
      return torch::tensor(values).view({1, rows, columns}).repeat({count, 1, 1}).requires_grad_();
    };
    using L = ThetaLayout;
    w1 = part(L::w1, kHiddenCount, 3), b1 = part(L::b1, kHiddenCount, 1);
    w2 = part(L::w2, kHiddenCount, kHiddenCount), b2 = part(L::b2, kHiddenCount, 1);
    w3 = part(L::w3, 1, kHiddenCount), b3 = part(L::b3, 1, 1);
  }

  std::vector<torch::Tensor> parameters() const { return {w1, b1, w2, b2, w3, b3}; }

  torch::Tensor forward(const torch::Tensor& x) const {
    const torch::Tensor first = torch::leaky_relu(torch::baddbmm(b1, w1, x), 0.01);
    return torch::baddbmm(b3, w3, torch::leaky_relu(torch::baddbmm(b2, w2, first), 0.01));
  }
};

constexpr int kMinibatchCount = kSupportPointCount / kMinibatchPointCount;

struct TorchMinibatch {
  torch::Tensor x, phi, mask;  // count x 3 x P, 1 x 1 x P, 1 x 1 x P (already divided by the number of valid points)
  double valid_count = 0.0;
};

TorchMinibatch torchMinibatch(const WeightingFunction& function, int index, int64_t count) {
  const PointSet& points = stratifiedSupportPoints();
  const int begin = index * kMinibatchPointCount;
  TorchMinibatch result{torch::empty({1, 3, kMinibatchPointCount}), torch::empty({1, 1, kMinibatchPointCount}),
                        torch::empty({1, 1, kMinibatchPointCount})};
  float* x = result.x.data_ptr<float>();
  std::copy_n(&points.x[begin], kMinibatchPointCount, x);
  std::copy_n(&points.y[begin], kMinibatchPointCount, x + kMinibatchPointCount);
  std::copy_n(&points.z[begin], kMinibatchPointCount, x + 2 * kMinibatchPointCount);
  std::copy_n(&function.phi[begin], kMinibatchPointCount, result.phi.data_ptr<float>());
  std::copy_n(&function.mask[begin], kMinibatchPointCount, result.mask.data_ptr<float>());
  result.valid_count = result.mask.sum().item<float>();
  result.mask /= result.valid_count;
  result.x = result.x.expand({count, 3, kMinibatchPointCount}).contiguous();
  return result;
}

// RMSE over all support points of the first of the networks.
double torchRmse(const TorchNetworks& networks, const std::vector<TorchMinibatch>& minibatches,
                 const WeightingFunction& function) {
  const torch::NoGradGuard guard;
  double sum = 0.0;
  for (const TorchMinibatch& batch : minibatches) {
    const torch::Tensor error = ((networks.forward(batch.x) - batch.phi).square() * batch.mask)[0].sum();
    sum += error.item<double>() * batch.valid_count;
  }
  return std::sqrt(sum / function.validCount());
}

void adamByTorch(benchmark::State& state) {
  useOneThread();
  const int64_t count = state.range(0);
  const WeightingFunction function = wallFunction();
  std::vector<TorchMinibatch> minibatches;
  for (int k = 0; k < kMinibatchCount; ++k) minibatches.push_back(torchMinibatch(function, k, count));
  TorchNetworks networks(count);
  for (auto _ : state) {
    networks = TorchNetworks(count);
    torch::optim::Adam adam(networks.parameters(), torch::optim::AdamOptions(kAdamRate).betas({0.8, 0.99}));
    for (int step = 0; step < kAdamSteps; ++step) {
      const TorchMinibatch& batch = minibatches[step % kMinibatchCount];
      const double rate = kAdamRate * 0.5 * (1.0 + std::cos(M_PI * step / kAdamSteps));
      static_cast<torch::optim::AdamOptions&>(adam.param_groups()[0].options()).lr(rate);
      adam.zero_grad();
      ((networks.forward(batch.x) - batch.phi).square() * batch.mask).sum().backward();
      adam.step();
    }
  }
  countFunctions(state, static_cast<double>(count));
  state.counters["rmse"] = torchRmse(networks, minibatches, function);
}
BENCHMARK(adamByTorch)->Name("peer/adam_500_steps/libtorch/functions")->Arg(1)->Arg(kPeerBatch)->Unit(benchmark::kMillisecond);

void adamByUs(benchmark::State& state) {
  const WeightingFunction function = wallFunction();
  const Theta start = randomTheta(Representation::mlp(), 1);
  AdamOptions options;
  options.steps = kAdamSteps;
  options.learning_rate = kAdamRate;
  options.eigenbasis = false;  // the same algorithm on both sides
  FitResult result;
  for (auto _ : state) result = fitAdam(Representation::mlp(), function, start, options);
  countFunctions(state, 1.0);
  state.counters["rmse"] = result.rmse;
}
BENCHMARK(adamByUs)->Name("peer/adam_500_steps/ours")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace nlg
