// Loss and gradient of a batch of theta on their own functions, for autograd, by the shared kernel.
#pragma once

#include <torch/types.h>

#include <vector>

#include "nlg/representation.h"
#include "train/generator/sample_order.h"
#include "train/generator/training_data.h"

namespace nlg {

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

}  // namespace nlg
