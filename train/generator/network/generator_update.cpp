#include "train/generator/network/generator_update.h"

#include <torch/csrc/autograd/autograd.h>

#include <algorithm>
#include <cmath>

#include "runtime_eval/fit/adam_update.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

constexpr double kBeta1 = 0.9, kBeta2 = 0.99;

// Parameters that a thread takes at once: what it reads and writes of them stays in its second-level cache.
constexpr int64_t kParametersABlock = 16384;

// Some numbers of one parameter.
struct Block {
  size_t parameter = 0;
  int64_t first = 0, count = 0;
};

std::vector<Block> blocksOf(const std::vector<int64_t>& begin) {
  std::vector<Block> blocks;
  for (size_t i = 0; i + 1 < begin.size(); ++i) {
    const int64_t count = begin[i + 1] - begin[i];
    for (int64_t first = 0; first < count; first += kParametersABlock)
      blocks.push_back({i, first, std::min(kParametersABlock, count - first)});
  }
  return blocks;
}

// The parameters' numbers on the processor, to be changed in place; those of another device are put back there.
class ProcessorNumbers {
 public:
  explicit ProcessorNumbers(const GeneratorNetwork& network) : parameters_(network->parameters()) {
    for (const torch::Tensor& parameter : parameters_) numbers_.push_back(parameter.detach().cpu());
  }
  float* begin(size_t parameter) const { return numbers_[parameter].data_ptr<float>(); }
  void putBack() const {
    const torch::NoGradGuard no_gradient;
    for (size_t i = 0; i < parameters_.size(); ++i) {
      if (!parameters_[i].is_cpu()) torch::Tensor(parameters_[i]).copy_(numbers_[i]);
    }
  }

 private:
  std::vector<torch::Tensor> parameters_, numbers_;
};

}  // namespace

ParameterMoments zeroMoments(const GeneratorNetwork& network) {
  ParameterMoments moments;
  for (const torch::Tensor& parameter : network->parameters()) {
    moments.mean.push_back(torch::zeros(parameter.sizes()));
    moments.square.push_back(torch::zeros(parameter.sizes()));
  }
  return moments;
}

BatchGradient::BatchGradient(const GeneratorNetwork& network) : begin_{0} {
  for (const torch::Tensor& parameter : network->parameters()) begin_.push_back(begin_.back() + parameter.numel());
  row_ = torch::zeros({begin_.back() + 1});
}

void BatchGradient::compute(const GeneratorNetwork& network, int part_count, int thread_count,
                            const std::function<torch::Tensor(int)>& lossOf) {
  const std::vector<torch::Tensor> parameters = network->parameters();
  std::vector<std::vector<torch::Tensor>> gradients(static_cast<size_t>(part_count));
  std::vector<float> losses(gradients.size());
  // each part on one thread, with a graph of its own
  parallelFor(gradients.size(), thread_count, [&](uint64_t part, int) {
    const torch::Tensor loss = lossOf(static_cast<int>(part));
    // undefined for a parameter that nothing of this part used
    gradients[part] = torch::autograd::grad({loss}, parameters, {}, c10::nullopt, false, true);
    for (torch::Tensor& gradient : gradients[part]) {
      if (gradient.defined()) gradient = gradient.cpu().contiguous();
    }
    losses[part] = loss.item<float>();
  });
  // parts add up in their order, so that the gradient does not depend on threads
  float* row = row_.data_ptr<float>();
  const std::vector<Block> blocks = blocksOf(begin_);
  parallelFor(blocks.size(), thread_count, [&](uint64_t b, int) {
    const Block& block = blocks[b];
    float* sum = row + begin_[block.parameter] + block.first;
    std::fill_n(sum, block.count, 0.0f);
    for (const std::vector<torch::Tensor>& of_part : gradients) {
      if (!of_part[block.parameter].defined()) continue;
      const float* gradient = of_part[block.parameter].data_ptr<float>() + block.first;
      for (int64_t k = 0; k < block.count; ++k) sum[k] += gradient[k];
    }
  });
  // the loss stands behind the gradient: processes sum both at once
  row[begin_.back()] = 0.0f;
  for (const float loss : losses) row[begin_.back()] += loss;
}

double BatchGradient::loss() const { return row_.data_ptr<float>()[begin_.back()]; }

double BatchGradient::norm() const {
  const torch::Tensor gradient = row_.slice(0, 0, begin_.back());
  return std::sqrt(gradient.dot(gradient).item<double>());
}

const float* BatchGradient::ofParameter(size_t parameter) const { return row_.data_ptr<float>() + begin_[parameter]; }

void takeStep(const GeneratorStep& step, const BatchGradient& gradient, int thread_count, GeneratorNetwork& network,
              ParameterMoments& moments, GeneratorNetwork& average) {
  AdamStep adam;
  adam.learning_rate = step.learning_rate;
  adam.beta1 = kBeta1;
  adam.beta2 = kBeta2;
  adam.beta1_power = std::pow(kBeta1, static_cast<double>(step.number));
  adam.beta2_power = std::pow(kBeta2, static_cast<double>(step.number));
  // clipping is a factor on the gradient
  adam.gradient_scale = static_cast<float>(std::min(1.0, step.gradient_clip / (step.gradient_norm + 1e-6)));
  const float share = static_cast<float>(step.average_share);
  const ProcessorNumbers of_network(network), of_average(average);
  const std::vector<Block> blocks = blocksOf(gradient.begin());
  // a block of parameters is stepped and averaged while it is in the cache
  parallelFor(blocks.size(), thread_count, [&](uint64_t b, int) {
    const Block& block = blocks[b];
    const size_t i = block.parameter;
    float *numbers = of_network.begin(i) + block.first, *averages = of_average.begin(i) + block.first;
    float *mean = moments.mean[i].data_ptr<float>() + block.first, *square = moments.square[i].data_ptr<float>() + block.first;
    AdamStep own = adam;
    own.learning_rate *= network->rateFactor(i);
    adamUpdate(own, block.count, gradient.ofParameter(i) + block.first, mean, square, numbers);
    for (int64_t k = 0; k < block.count; ++k) averages[k] += share * (numbers[k] - averages[k]);
  });
  of_network.putBack();
  of_average.putBack();
}

}  // namespace nlg
