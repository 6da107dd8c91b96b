#include "validate/light/neural/learner.h"

#include <torch/autograd.h>
#include <torch/utils.h>

#include <cmath>
#include <numbers>

#include "tool/error.h"
#include "tool/processor_time.h"

namespace nlg {
namespace {

constexpr float kFirstDecay = 0.9f, kSecondDecay = 0.99f, kTiny = 1e-15f;

class Adam {
 public:
  explicit Adam(const std::vector<torch::Tensor>& parameters) {
    for (const torch::Tensor& tensor : parameters) moments_.emplace_back(static_cast<size_t>(2 * tensor.numel()), 0.0f);
  }

  void step(std::vector<torch::Tensor>& parameters, float rate) {
    ++step_;
    const auto first_share = static_cast<float>(1.0 - std::pow(kFirstDecay, step_));
    const auto second_share = static_cast<float>(1.0 - std::pow(kSecondDecay, step_));
    const float scaled = rate / first_share, unit = 1.0f / second_share;
    for (size_t t = 0; t < parameters.size(); ++t) {
      float* value = parameters[t].data_ptr<float>();
      torch::Tensor& slope = parameters[t].mutable_grad();
      const float* gradient = slope.data_ptr<float>();
      float* moment = moments_[t].data();
      const int64_t count = parameters[t].numel();
      for (int64_t i = 0; i < count; ++i, moment += 2) {
        const float g = gradient[i];
        if (g == 0.0f) continue;
        moment[0] += (1.0f - kFirstDecay) * (g - moment[0]);
        moment[1] += (1.0f - kSecondDecay) * (g * g - moment[1]);
        value[i] -= scaled * moment[0] / (std::sqrt(moment[1] * unit) + kTiny);
      }
      // the next backward pass leaves its own there, without a sum
      slope.reset();
    }
  }

 private:
  std::vector<std::vector<float>> moments_;  // by tensor; first and second beside each other
  int step_ = 0;
};

}  // namespace

TrainingRecord train(Learner* learner, const TrainingOptions& options) {
  NLG_CHECK(options.check_steps, >=, 1);
  const double start_s = threadSeconds();
  Adam adam(learner->parameters());
  Random random(options.seed);
  TrainingRecord record;
  // the parameters with the least held-out loss so far
  std::vector<torch::Tensor> best;
  const auto check = [&] {
    const double loss = learner->heldOutLoss();
    if (!std::isfinite(loss))
      throw NumericalError("training of light", "step " + std::to_string(record.steps), "the held-out loss", loss);
    if (!best.empty() && !(loss < record.held_out_loss)) return;
    record.held_out_loss = loss;
    record.best_step = record.steps;
    best.clear();
    for (const torch::Tensor& tensor : learner->parameters()) best.push_back(tensor.detach().clone());
  };
  // before the first step, too: there always is a best
  check();
  while (record.steps < options.steps && record.steps - record.best_step < options.patience * options.check_steps) {
    // the rate falls along half a cosine; training ends early when checks no longer improve
    const double share = static_cast<double>(record.steps) / options.steps;
    learner->loss(&random).backward();
    adam.step(learner->parameters(), options.rate * static_cast<float>(0.5 * (1.0 + std::cos(std::numbers::pi * share))));
    ++record.steps;
    if (record.steps % options.check_steps == 0 || record.steps == options.steps) check();
  }
  // what is exported is the best, not the last
  const torch::NoGradGuard no_gradients;
  for (size_t t = 0; t < best.size(); ++t) learner->parameters()[t].copy_(best[t]);
  record.processor_s = threadSeconds() - start_s;
  return record;
}

torch::Tensor relativeSquares(const torch::Tensor& prediction, const torch::Tensor& target) {
  const torch::Tensor constant = prediction.detach();
  return ((prediction - target).square() / (constant.square() + kLossFloor * kLossFloor)).mean();
}

double evenSquares(const torch::Tensor& prediction, const torch::Tensor& target) {
  const torch::Tensor divisor = 0.5 * (prediction.square() + target.square()) + kLossFloor * kLossFloor;
  return ((prediction - target).square() / divisor).mean().item<double>();
}

torch::Tensor symmetricShares(const torch::Tensor& prediction, const torch::Tensor& target) {
  return ((prediction - target).abs() / (prediction.abs() + target.abs() + kShareFloor)).mean();
}

}  // namespace nlg
