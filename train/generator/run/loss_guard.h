// Detects divergence of the training, and rolls back to the last good state.
#pragma once

#include <vector>

#include "train/generator/run/checkpoint.h"

namespace nlg {

class LossGuard {
 public:
  // After so many rollbacks the next failure ends the run.
  static constexpr int kMaxRollbacks = 5;

  // state              good, as a fresh or a loaded one is
  // divergence_ratio   a loss over so many times the median of the last ones counts as diverged
  LossGuard(const TrainingState& state, double divergence_ratio);

  // Whether a step with this loss and this norm of its gradient may be taken.
  bool accepts(const TrainingState& state, double loss, double gradient_norm) const;

  // Remembers a state to go back to; false, and the one before stays, when its parameters are not finite.
  bool keep(const TrainingState& state);

  // Puts the state back to the last one kept. What counts on: `draw`, so that the samples since then are not taken again, and
  // `rollbacks`, each of which halves the learning rate for the rest of the run.
  // throws   NumericalError naming quantity and value, after the state has been put back, when it had been kMaxRollbacks times
  void rollBack(TrainingState* state, const char* quantity, double value) const;

 private:
  void copy(const TrainingState& state);

  double divergence_ratio_;
  int64_t step_ = 0;
  std::vector<double> recent_losses_;
  std::vector<torch::Tensor> network_, average_;
  ParameterMoments moments_;
};

// Notes the loss of a step that was taken.
void noteLoss(TrainingState* state, double loss);

}  // namespace nlg
