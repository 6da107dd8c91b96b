#include "train/generator/run/loss_guard.h"

#include <algorithm>
#include <cmath>
#include <iostream>

#include "tool/error.h"

namespace nlg {
namespace {

constexpr size_t kMedianLosses = 101;  // the median is over so many losses …
constexpr size_t kFewestLosses = 20;   // … or fewer at the start, where the loss falls fast and nothing is judged

double medianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<torch::Tensor> copyOf(const std::vector<torch::Tensor>& tensors) {
  std::vector<torch::Tensor> copies;
  for (const torch::Tensor& tensor : tensors) copies.push_back(tensor.detach().clone());
  return copies;
}

void putBack(const std::vector<torch::Tensor>& copies, std::vector<torch::Tensor> tensors) {
  for (size_t i = 0; i < copies.size(); ++i) tensors[i].copy_(copies[i]);
}

bool isFinite(const std::vector<torch::Tensor>& tensors) {
  return std::all_of(tensors.begin(), tensors.end(),
                     [](const torch::Tensor& t) { return std::isfinite(t.sum().item<double>()); });
}

}  // namespace

LossGuard::LossGuard(const TrainingState& state, double divergence_ratio) : divergence_ratio_(divergence_ratio) {
  // numbers that are wrong from the start are found by the first step
  copy(state);
}

bool LossGuard::accepts(const TrainingState& state, double loss, double gradient_norm) const {
  if (!std::isfinite(loss) || !std::isfinite(gradient_norm)) return false;
  return state.recent_losses.size() < kFewestLosses || loss <= divergence_ratio_ * medianOf(state.recent_losses);
}

bool LossGuard::keep(const TrainingState& state) {
  torch::NoGradGuard no_gradient;
  if (!isFinite(state.network->parameters())) return false;
  copy(state);
  return true;
}

void LossGuard::copy(const TrainingState& state) {
  torch::NoGradGuard no_gradient;
  network_ = copyOf(state.network->parameters());
  average_ = copyOf(state.average->parameters());
  moments_ = {copyOf(state.moments.mean), copyOf(state.moments.square)};
  step_ = state.step;
  recent_losses_ = state.recent_losses;
}

void LossGuard::rollBack(TrainingState* state, const char* quantity, double value) const {
  const int64_t failed_step = state->step;
  {
    torch::NoGradGuard no_gradient;
    putBack(network_, state->network->parameters());
    putBack(average_, state->average->parameters());
    putBack(moments_.mean, state->moments.mean);
    putBack(moments_.square, state->moments.square);
  }
  state->step = step_;
  state->recent_losses = recent_losses_;
  if (state->rollbacks == kMaxRollbacks) {
    throw NumericalError("train",
                         "step " + std::to_string(failed_step) + ", after " + std::to_string(kMaxRollbacks) + " rollbacks",
                         quantity, value);
  }
  ++state->rollbacks;
  std::cerr << "nlg-train: step " << failed_step << ": " << quantity << " is " << value << ": back to step " << step_
            << " at half the rate, other samples (rollback " << state->rollbacks << " of " << kMaxRollbacks << ")\n";
}

void noteLoss(TrainingState* state, double loss) {
  std::vector<double>& losses = state->recent_losses;
  if (losses.size() == kMedianLosses) losses.erase(losses.begin());
  losses.push_back(loss);
}

}  // namespace nlg
