// Stages of theta in training: predicted, then with its last layer solved.
//
// The same way as at bake time (nlg/policy.h), but differentiable.
#pragma once

#include "train/generator/function_loss.h"
#include "train/generator/generator_network.h"

namespace nlg {

struct ThetaStages {
  // One a stage, B each, differentiable: of the predicted theta; of that with its last layer solved (networks with a linear
  // output, when the shape says so).
  std::vector<torch::Tensor> mean_squares;
};

// Theta of all stages for the samples, each judged on its sample's points.
ThetaStages runStages(GeneratorNetwork& network, const Representation& representation, const TrainingData& data,
                      const std::vector<Sample>& samples, const LossOptions& loss);

// How the stages do on held-out functions.
struct HeldOutError {
  double network = 0.0;  // mean blend RMSE of one pass of the network alone
  double final = 0.0;    // … and of each function's best stage
  double tent = 0.0;     // … and of the bare tent, which a generator must beat
};

// Over all valid support points, for at most `limit` functions, taken at equal distances from those whose bare tent has a blend RMSE
// above `tent_rmse`; zeros when there are none. The same on any number of threads.
HeldOutError heldOutError(GeneratorNetwork& network, const Representation& representation, const TrainingData& data,
                          const LossOptions& loss, int limit, double tent_rmse = -1.0, int thread_count = 1);

// Coefficients of the samples' functions, mirrored: B x K.
torch::Tensor coefficientBatch(const TrainingData& data, const std::vector<Sample>& samples);

}  // namespace nlg
