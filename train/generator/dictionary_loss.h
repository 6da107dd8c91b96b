// Loss of codes under the dictionary that is trained with them, for autograd: both learn from it.
//
// All samples are judged on the same points, so that their logits are one product of matrices.
#pragma once

#include <vector>

#include "train/generator/generator_network.h"
#include "train/generator/sample_order.h"
#include "train/generator/training_data.h"

namespace nlg {

struct DictionaryLossOptions {
  // Of the slope that the sigmoid is given where it has shut a point: without it such points never come back (docs/lab/training.md). 0 for
  // what is judged, not trained on.
  double leak = 0.0;
  LossOptions loss;
};

// The loss: mean of weighed squares over the valid points of each sample's function.
//
// z             B x K
// point_batch   of stratumOrder(), from 0; all samples are judged on its points. -1: on all points
// returns       B
torch::Tensor codeMeanSquares(GeneratorNetwork& network, const torch::Tensor& z, const TrainingData& data,
                              const std::vector<Sample>& samples, int point_batch, const DictionaryLossOptions& options);

}  // namespace nlg
