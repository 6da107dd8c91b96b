#include "validate/light/neural/dense_light.h"

#include <torch/utils.h>

#include <algorithm>
#include <cmath>

#include "validate/light/neural/dense_training.h"

namespace nlg {
namespace {

constexpr double kLogGain = 10.0;

class DenseLearner : public Learner {
 public:
  DenseLearner(const LightSamples& samples, const DenseShape& shape, DenseCode code, int64_t batch, uint64_t seed)
      : samples_(samples), shape_(shape), code_(code), batch_(batch), parameters_({initialParameters(shape, seed)}) {}

  std::vector<torch::Tensor>& parameters() override { return parameters_; }
  torch::Tensor loss(Random* random) override { return lossOf(samples_.draw(batch_, random)); }
  double heldOutLoss() override {
    const torch::NoGradGuard no_gradients;
    return lossOf(samples_.heldOut()).item<double>();
  }

 private:
  torch::Tensor lossOf(const SampleBatch& batch) {
    const torch::Tensor output = evaluateBatch(shape_, parameters_[0], batch.input);
    if (code_ == DenseCode::plain) return symmetricShares(output, batch.target);
    return (output - (kLogGain * batch.target).log1p()).square().mean();
  }

  const LightSamples& samples_;
  const DenseShape shape_;
  const DenseCode code_;
  const int64_t batch_;
  std::vector<torch::Tensor> parameters_;
};

}  // namespace

float decoded(DenseCode code, float output) {
  return std::max(0.0f, code == DenseCode::plain ? output : std::expm1(output) / static_cast<float>(kLogGain));
}

std::vector<float> trainDense(const LightSamples& samples, const DenseShape& shape, DenseCode code, int64_t batch,
                              const TrainingOptions& options, TrainingRecord* record) {
  DenseLearner learner(samples, shape, code, batch, mixSeed(options.seed, 1));
  *record = train(&learner, options);
  return floatsOf(learner.parameters()[0]);
}

}  // namespace nlg
