// The loss of generated theta against their own weighting functions, as a libtorch autograd function around the shared kernel.
#pragma once

#include <torch/types.h>

#include <vector>

#include "runtime_eval/evaluator/representation.h"
#include "train/generator/sample_order.h"
#include "train/generator/training_data.h"

namespace nlg {

// Mean squared error of each theta over the valid points of its sample's stratum; differentiable by theta.
//
// theta     B x D, float
// samples   B
// returns   B, float; 0 (and no gradient) for a stratum without a valid point
// Work is split over libtorch's threads by function, so that the result does not depend on their number.
torch::Tensor functionLoss(const torch::Tensor& theta, const Representation& representation, const TrainingData& data,
                           const std::vector<Sample>& samples);

}  // namespace nlg
