// The shared kernel on a batch of samples: how wrong theta are on their own functions, and which way is down.
#pragma once

#include <torch/types.h>

#include <vector>

#include "runtime_eval/evaluator/representation.h"
#include "train/generator/sample_order.h"
#include "train/generator/training_data.h"

namespace nlg {

// Of each theta over the valid points of its sample's batches of points. No autograd: see differentiable().
struct ThetaErrors {
  torch::Tensor mean_square;  // B; 0 where no point is valid
  torch::Tensor gradient;     // B x D: of mean_square by theta; 0 where no point is valid
};

// theta     B x D, float, on the processor
// samples   B
// Work is split over libtorch's threads by function, so that the result does not depend on their number.
ThetaErrors measureTheta(const torch::Tensor& theta, const Representation& representation, const TrainingData& data,
                         const std::vector<Sample>& samples);

// errors.mean_square as a function of theta, for autograd: the value and the gradient that were measured at this very theta.
torch::Tensor differentiable(const ThetaErrors& errors, const torch::Tensor& theta);

// theta with the last layer of each solved exactly on its sample's points (fit/last_layer.h). Networks with a linear output only.
// To autograd the solution is a constant: at the minimum over the last layer the loss does not depend on it to first order, so
// the gradient by the other parameters is exact (envelope theorem).
torch::Tensor solveLastLayers(const torch::Tensor& theta, const Representation& representation, const TrainingData& data,
                              const std::vector<Sample>& samples);

}  // namespace nlg
