// One step of the generator's parameters: the gradient of a batch, summed from its parts, and Adam.
//
// What libtorch's own optimizer, clipping and averages do in some twenty passes over all parameters is one here.
#pragma once

#include <functional>
#include <vector>

#include "train/generator/network/generator_network.h"

namespace nlg {

// Adam's moments, in the order and the shapes of the network's parameters; on the processor.
struct ParameterMoments {
  std::vector<torch::Tensor> mean, square;
};

// As before the first step.
ParameterMoments zeroMoments(const GeneratorNetwork& network);

// The gradient of a batch: of one parameter after another in the network's order, and the loss behind them, in one row. That row is what
// processes that train together add up.
class BatchGradient {
 public:
  explicit BatchGradient(const GeneratorNetwork& network);

  // Computes several parts at once, and adds them up in their order: the same bits on any number of threads. libtorch is to
  // compute on each of them alone (torch_threads.h).
  // lossOf   (part, from 0) → the part's share of the batch's loss: a scalar
  void compute(const GeneratorNetwork& network, int part_count, int thread_count,
               const std::function<torch::Tensor(int)>& lossOf);

  torch::Tensor& row() { return row_; }
  double loss() const;
  double norm() const;  // of the gradient
  const float* ofParameter(size_t parameter) const;
  const std::vector<int64_t>& begin() const { return begin_; }  // where each parameter's begins in the row, and the loss

 private:
  torch::Tensor row_;  // on the processor
  std::vector<int64_t> begin_;
};

struct GeneratorStep {
  int64_t number = 1;  // from 1
  double learning_rate = 0.0;
  double gradient_norm = 0.0;
  double gradient_clip = 1.0;   // a gradient with a larger norm is followed as if it had this one
  double average_share = 0.01;  // of the way from the averaged weights to the new ones
};

// average   follows the network: average += average_share * (network - average)
void takeStep(const GeneratorStep& step, const BatchGradient& gradient, int thread_count, GeneratorNetwork& network,
              ParameterMoments& moments, GeneratorNetwork& average);

}  // namespace nlg
