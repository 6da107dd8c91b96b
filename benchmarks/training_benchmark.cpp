// A training step of the generator alone, ours (the shared kernel, parts of the batch at once, one pass over the parameters) against the
// same loss in libtorch's own differentiable operations and its own optimizer: batch 256, all 8192 points of every function, two
// threads. Both take turns in one case, so that whatever else the machine does slows both alike. OpenBLAS
// works on one thread for both: on two of its own the step in autograd is no faster.

#include <benchmark/benchmark.h>
#include <torch/torch.h>

#include <algorithm>
#include <chrono>

#include "benchmarks/random_generator.h"
#include "benchmarks/sample_function.h"
#include "runtime_eval/fit/adam.h"
#include "tool/parallel_for.h"
#include "train/generator/function_loss.h"
#include "train/generator/generator_network.h"
#include "train/generator/generator_update.h"
#include "train/generator/theta_stages.h"
#include "train/generator/torch_threads.h"

namespace nlg {
namespace {

constexpr int kBatch = 256, kParts = 2, kThreads = 2, kFunctionCount = 2048;
constexpr double kRate = 1e-3, kAverageShare = 1e-3;
constexpr double kSameLoss = 1e-5;  // relative: what rounding may make of one

GeneratorShape withoutCorrection() {
  GeneratorShape shape;
  shape.correction_steps = 0;
  return shape;
}

// Training's own step.
struct TrainingStep {
  GeneratorNetwork network, average;
  ParameterMoments moments;
  BatchGradient gradient;
  int64_t number = 0;

  explicit TrainingStep(const Theta& theta0)
      : network(withoutCorrection(), theta0, 1),
        average(withoutCorrection(), theta0, 1),
        moments(zeroMoments(network)),
        gradient(network) {}

  // lossOf   theta, samples → mean squared errors, one a sample
  // returns  the step's loss
  template <class LossOf>
  double run(const TrainingData& data, const std::vector<Sample>& samples, const LossOf& lossOf) {
    gradient.compute(network, kParts, kThreads, [&](int part) {
      const std::vector<Sample> some(samples.begin() + part * kBatch / kParts, samples.begin() + (part + 1) * kBatch / kParts);
      const torch::Tensor theta = network->forward(coefficientBatch(data, some));
      return (lossOf(theta, some) + 1e-6).sqrt().sum() / kBatch;
    });
    takeStep({++number, kRate, gradient.norm(), 1.0, kAverageShare}, gradient, kThreads, network, moments, average);
    return gradient.loss();
  }
};

// The same with what libtorch brings.
struct LibtorchStep {
  GeneratorNetwork network, average;
  torch::optim::Adam optimizer;

  explicit LibtorchStep(const Theta& theta0)
      : network(withoutCorrection(), theta0, 1),
        average(withoutCorrection(), theta0, 1),
        optimizer(network->parameters(), torch::optim::AdamOptions(kRate).betas({0.9, 0.99})) {}

  template <class LossOf>
  double run(const TrainingData& data, const std::vector<Sample>& samples, const LossOf& lossOf) {
    const torch::Tensor theta = network->forward(coefficientBatch(data, samples));
    const torch::Tensor loss = (lossOf(theta, samples) + 1e-6).sqrt().mean();
    optimizer.zero_grad();
    loss.backward();
    torch::nn::utils::clip_grad_norm_(network->parameters(), 1.0);
    optimizer.step();
    const torch::NoGradGuard guard;
    const std::vector<torch::Tensor> from = network->parameters(), to = average->parameters();
    for (size_t i = 0; i < from.size(); ++i) to[i].lerp_(from[i], kAverageShare);
    return loss.item<double>();
  }
};

// The shared kernel over all points of every function.
torch::Tensor kernelLoss(const TrainingData& data, const Representation& representation, const torch::Tensor& theta,
                         std::vector<Sample> samples) {
  for (Sample& sample : samples) sample.batch_count = pointOrder(representation).batchCount();
  return differentiable(measureTheta(theta, {representation, data, samples}), theta);
}

// The tiny networks, their tent and the error as a chain of libtorch's operations.
struct AutogradLoss {
  const TrainingData& data;
  Representation representation;
  torch::Tensor points, tent;  // 1 x 3 x P, 1 x P
  torch::Tensor phi, mask;     // B x P

  AutogradLoss(const TrainingData& functions, const Representation& kind)
      : data(functions), representation(kind), points(torch::empty({1, 3, kSupportPointCount})) {
    const PointSet& set = pointOrder(kind).points;
    std::copy_n(set.x.data(), kSupportPointCount, points.data_ptr<float>());
    std::copy_n(set.y.data(), kSupportPointCount, points.data_ptr<float>() + kSupportPointCount);
    std::copy_n(set.z.data(), kSupportPointCount, points.data_ptr<float>() + 2 * kSupportPointCount);
    tent = (1 - points[0].abs()).prod(0, true);
    phi = torch::empty({kBatch, kSupportPointCount});
    mask = torch::empty_like(phi);
  }

  void decode(const std::vector<Sample>& samples) const {
    parallelFor(kBatch, kThreads, [&](uint64_t b, int) {
      const WeightingFunction function =
          decodeFunction(data.function(samples[b].function), pointOrder(representation), samples[b].mirror);
      std::copy_n(function.phi.data(), kSupportPointCount, phi.data_ptr<float>() + b * kSupportPointCount);
      std::copy_n(function.mask.data(), kSupportPointCount, mask.data_ptr<float>() + b * kSupportPointCount);
    });
  }

  torch::Tensor operator()(const torch::Tensor& theta, const std::vector<Sample>& samples) const {
    decode(samples);
    using L = ThetaLayout;
    const auto part = [&](int first, int64_t rows, int64_t columns) {
      return theta.slice(1, first, first + rows * columns).reshape({kBatch, rows, columns});
    };
    constexpr int64_t kHidden = kHiddenCount;
    const torch::Tensor x = points.expand({kBatch, 3, kSupportPointCount});
    const torch::Tensor first = torch::leaky_relu(torch::baddbmm(part(L::b1, kHidden, 1), part(L::w1, kHidden, 3), x), 0.01);
    const torch::Tensor second =
        torch::leaky_relu(torch::baddbmm(part(L::b2, kHidden, 1), part(L::w2, kHidden, kHidden), first), 0.01);
    torch::Tensor value = torch::baddbmm(part(L::b3, 1, 1), part(L::w3, 1, kHidden), second).squeeze(1);
    if (representation.tentFactor()) value = value * tent;
    return ((value - phi).square() * mask).sum(1) / mask.sum(1);
  }
};

FunctionSet wallSet() {
  FunctionSet set;
  set.pattern_hash = supportPattern().hash;
  set.point_count = kSupportPointCount;
  set.scene_idx.assign(kFunctionCount, 0);
  set.scene_ids = set.families = {"walls"};
  appendStoredWalls(kFunctionCount, &set.phi, &set.validity);
  return set;
}

std::vector<Sample> drawSamples(Random& random) {
  std::vector<Sample> samples(kBatch);
  for (Sample& sample : samples) {
    sample.function = static_cast<int64_t>(random.below(kFunctionCount));
    sample.mirror = static_cast<int>(random.below(kMirrorCount));
  }
  return samples;
}

template <class Step>
double secondsOf(const Step& step) {
  const auto start = std::chrono::steady_clock::now();
  step();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void trainingStep(benchmark::State& state, const Representation& representation) {
  const int threads_before = torch::get_num_threads();
  computeOnCallingThreads();
  const BasisData basis = randomGenerator().basis;
  const TrainingData data(wallSet(), basis, basis);
  const Theta theta0 = randomTheta(representation, 1);
  TrainingStep with_kernel(theta0);
  LibtorchStep with_autograd(theta0);
  AutogradLoss autograd(data, representation);
  const auto kernel = [&](const torch::Tensor& theta, const std::vector<Sample>& samples) {
    return kernelLoss(data, representation, theta, samples);
  };
  Random random(1);
  const auto runKernel = [&](const std::vector<Sample>& samples) {
    torch::set_num_threads(1);  // of this thread, one of those that share the parts
    return with_kernel.run(data, samples, kernel);
  };
  const auto runAutograd = [&](const std::vector<Sample>& samples) {
    torch::set_num_threads(kThreads);
    return with_autograd.run(data, samples, autograd);
  };
  // both compute the same: before the networks drift apart by rounding
  const std::vector<Sample> first = drawSamples(random);
  const double kernel_loss = runKernel(first), autograd_loss = runAutograd(first);
  if (!(std::abs(kernel_loss - autograd_loss) <= kSameLoss * autograd_loss)) {
    torch::set_num_threads(threads_before);
    return state.SkipWithError("kernel and autograd do not have the same loss");
  }
  double kernel_s = 0.0, autograd_s = 0.0;
  for (auto _ : state) {
    const std::vector<Sample> samples = drawSamples(random);
    kernel_s += secondsOf([&] { runKernel(samples); });
    autograd_s += secondsOf([&] { runAutograd(samples); });
  }
  const double samples = static_cast<double>(kBatch) * static_cast<double>(state.iterations());
  state.counters["kernel_samples/s"] = samples / kernel_s;
  state.counters["autograd_samples/s"] = samples / autograd_s;
  state.counters["ratio"] = autograd_s / kernel_s;
  torch::set_num_threads(threads_before);
}
BENCHMARK_CAPTURE(trainingStep, mlp, Representation::mlp())
    ->Name("peer/training_step/mlp")
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(trainingStep, tent_mlp, Representation::tentMlp())
    ->Name("peer/training_step/tent_mlp")
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace nlg
