// Trains a generator end to end: coefficients → theta → loss of theta on its own function.
#pragma once

#include <functional>
#include <memory>

#include "runtime_eval/evaluator/generator/generator_data.h"
#include "runtime_eval/fit/direct.h"
#include "tool/command/options.h"
#include "train/basis/basis_file.h"
#include "train/generator/data/sample_order.h"
#include "train/generator/data/training_data.h"
#include "train/generator/network/generator_update.h"
#include "train/generator/network/theta_stages.h"
#include "train/generator/run/checkpoint.h"
#include "train/generator/run/process_group.h"

namespace nlg {

struct TrainOptions {
  uint64_t seed = 1;
  int steps = 10000;
  int batch = 256;
  double learning_rate = 3e-3;   // the peak of the one-cycle schedule
  double warmup_share = 0.15;    // of the steps, rising; the rest falls along a cosine
  double gradient_clip = 1.0;    // largest norm of the whole gradient
  double average_decay = 0.999;  // of the averaged weights
  double error_power = 0.5;      // of a function's loss, before the mean over functions; 0.5: its blend RMSE
  int point_batches = 1;  // eighths of a network's points that a sample is judged on: 1, 2, 4 or 8; fields take all of theirs
  std::string input = "samples";  // or coefficients: what the generator reads (GeneratorInput)
  int coefficients = 0;  // of the basis, those of largest variance; of samples, trained components; 0: as many as the basis has
  double visibility_share = 0.25;  // of samples: drafts and moved doors show a generator no more than what probes see
  double whitening = 0.5;          // 1: coefficients have deviation 1; 0: their own, but for one factor (basis_fit.h)
  // Of every batch: drawn from the functions that take a theta at a bake alone. The others, for which the bare tent is enough, come
  // as often as the set has them in what is left, so that theta stays sane there.
  double theta_share = 0.95;
  double bare_tent_rmse = 0.002;  // a function that the bare tent gives so well takes no theta: the policy's own setting
  LossOptions loss = CheckOptions().loss();  // the bake's
  double divergence_ratio = 10;              // a loss over so many times the running median takes training back (loss_guard.h)
  double representation_slope = 0.01;        // LeakyReLU of the tiny network
  GeneratorShape shape;
  bool begins_trained =
      false;  // with a generator's numbers: dark points have their whole weight from the first step, codes no leak
  StartOptions start{.candidates = 2048};  // most random starts end badly: a good theta0 is found once and serves all functions
  int checkpoint_steps = 0;                // a checkpoint and a validation every so many steps; 0: every twentieth of them
  int validation_functions = 2048;         // at most so many held-out functions in the validation loss
  int threads = 1;
  torch::Device device = torch::kCPU;  // of the network; the loss of theta is computed on the processor
};

// One table for nlg-train and nlg-export.
void describeTrainOptions(TrainOptions& options, OptionTable& table);

// The basis that a run reads: all of it, or its components of largest variance, with coefficients whitened as the run asks; of samples,
// one whose components are still to be trained.
// throws   UsageError for an input of another name
BasisData usedBasis(const TrainOptions& options, const Basis& basis);

// Learning rate of a step before any rollback: linear from 1/25 of the peak over the warm-up, then a cosine down to 1/10000.
double oneCycleRate(const TrainOptions& options, int64_t step);

// theta0 for a training set: fitted to the bare tent for `mlp`, 0 for codes, fitted to the mean function of the set for the others
// (docs/lab/measurements.md).
Theta fitTheta0(const Representation& representation, const BasisFile& basis, const StartOptions& options);

// A fresh state: networks at theta0, optimizer, step 0.
TrainingState makeState(const TrainOptions& options, const Theta& theta0);

struct TrainReport {
  HeldOutError held_out;  // averaged weights
  double elapsed_s = 0.0;
  double samples_per_s = 0.0;
};

// Runs from state.step to options.steps; calls save() at every checkpoint and at the end. Losses and gradients that are not
// finite take training back (loss_guard.h).
//
// processes   those that train together, each calling this with the same state and data: every batch is split among them, and all
//             of them take the same steps. Validation and save() are the first one's.
// throws      NumericalError when going back does not help; the last checkpoint stays. InputError when another process is gone or
//             the training set's cache is damaged
TrainReport train(const TrainOptions& options, const Representation& representation, const TrainingData& training,
                  const TrainingData& held_out, TrainingState* state, const std::function<void()>& save,
                  const ProcessGroup& processes = ProcessGroup());

// One step at a given rate, without validation: what train() is made of.
class TrainStep {
 public:
  struct Result {
    double loss = 0.0;           // of the batch, before the step
    double gradient_norm = 0.0;  // before clipping
  };

  // All of them outlive it. Draws from state.draw on.
  TrainStep(const TrainOptions& options, const Representation& representation, const TrainingData& training,
            const TrainingState& state, const ProcessGroup& processes);

  // Draws a batch and computes its gradient, summed over the processes.
  Result computeGradient(TrainingState& state);
  // Clips the gradient that was computed last and steps along it.
  void apply(TrainingState& state, double rate);

 private:
  const TrainOptions& options_;
  const Representation& representation_;
  const TrainingData& training_;
  const ProcessGroup& processes_;
  SampleOrder order_;
  std::unique_ptr<WindowLoader> loader_;  // for a cache
  BatchGradient gradient_;
  double gradient_norm_ = 0.0;
};

}  // namespace nlg
