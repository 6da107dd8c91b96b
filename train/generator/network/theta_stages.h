// Stages of theta in training: predicted, then with its last layer solved.
//
// The same way as at bake time (nlg/policy.h), but differentiable.
#pragma once

#include <vector>

#include <torch/types.h>

#include "nlg/representation.h"
#include "train/generator/data/sample_order.h"
#include "train/generator/data/training_data.h"
#include "train/generator/network/generator_network.h"

namespace nlg {

// Loss of codes under the dictionary that is trained with them, for autograd: both learn from it.
//
// All samples are judged on the same points, so that their logits are one product of matrices.
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

// What a step judges thetas by: the points of every sample, decoded once for all stages.
class SampleTargets {
 public:
  SampleTargets(const Representation& representation, const TrainingData& data, const std::vector<Sample>& samples,
                const LossOptions& loss);

  // The points of one sample as the kernels read them; good while the targets live.
  struct Points {
    int first = 0, count = 0;  // places of the point order
    int valid_count = 0;
    const float *phi = nullptr, *mask = nullptr;  // count each
  };
  Points of(int64_t sample) const;

  const Representation& representation() const { return representation_; }
  int64_t count() const { return static_cast<int64_t>(places_.size()); }

 private:
  struct Places {
    int first = 0, count = 0, valid_count = 0;
  };
  Representation representation_;
  size_t stride_ = 0;  // floats from one sample to the next
  std::vector<Places> places_;
  AlignedFloats phi_, mask_;
};

// The loss of each theta over the valid points of its sample. No autograd: see differentiable().
struct ThetaErrors {
  torch::Tensor mean_square;  // B; 0 where no point is valid
  torch::Tensor gradient;     // B x D: of mean_square by theta; 0 where no point is valid
};

// theta   B x D, float, on the processor
ThetaErrors measureTheta(const torch::Tensor& theta, const SampleTargets& targets);

// errors.mean_square as a function of theta, for autograd: the value and the gradient that were measured at this very theta.
torch::Tensor differentiable(const ThetaErrors& errors, const torch::Tensor& theta);

// theta with the last layer of each solved exactly on its sample's points (fit/last_layer.h). Networks with a linear output only.
// To autograd the solution is a constant: at the minimum over the last layer the loss does not depend on it to first order, so
// the gradient by the other parameters is exact (envelope theorem).
torch::Tensor solveLastLayers(const torch::Tensor& theta, const SampleTargets& targets);

// Theta of all stages for the samples, each judged on its sample's points.
// returns   mean squares, one a stage, B each, differentiable: of the predicted theta; of that with its last layer solved (networks with
//           a linear output, when the shape says so)
std::vector<torch::Tensor> runStages(GeneratorNetwork& network, const Representation& representation, const TrainingData& data,
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

// What the network reads of the samples' functions, mirrored: B x inputCount().
torch::Tensor inputBatch(const TrainingData& data, const std::vector<Sample>& samples);

}  // namespace nlg
