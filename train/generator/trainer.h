// Trains a generator end to end: coefficients → theta → error of theta on its own function.
#pragma once

#include <functional>
#include <string>

#include "runtime_eval/fit/direct.h"
#include "tool/options.h"
#include "train/basis/basis_file.h"
#include "train/generator/checkpoint.h"
#include "train/generator/training_data.h"

namespace nlg {

struct TrainOptions {
  uint64_t seed = 1;
  int steps = 10000;
  int batch = 256;
  double learning_rate = 1e-3;   // the peak of the one-cycle schedule
  double warmup_share = 0.15;    // of the steps, rising; the rest falls along a cosine
  double gradient_clip = 1.0;    // largest norm of the whole gradient
  double average_decay = 0.999;  // of the averaged weights
  double error_power = 0.5;      // loss = mean over functions of (mean squared error + 1e-6) ^ error_power; 0.5: RMSE, 1: MSE
  double representation_slope = 0.01;  // LeakyReLU of the tiny network
  GeneratorShape shape;
  StartOptions start{.candidates = 2048};  // most random starts end badly: a good theta0 is found once and serves all functions
  int checkpoint_steps = 1000;             // a checkpoint and a validation every so many steps
  int validation_functions = 2048;         // at most so many held-out functions in the validation loss
  int threads = 1;
};

// One table for nlg-train and nlg-export.
void describeTrainOptions(TrainOptions& options, OptionTable& table);

// Learning rate of a step: linear from 1/25 of the peak over the warm-up, then a cosine down to 1/10000.
double oneCycleRate(const TrainOptions& options, int64_t step);

// theta0 for a training set: fitted to the bare tent for `mlp`, to the mean function of the set for the others
// (docs/measurements.md §7).
Theta fitTheta0(const Representation& representation, const BasisFile& basis, const StartOptions& options);

// A fresh state: networks at theta0, optimizer, step 0.
TrainingState makeState(const TrainOptions& options, const Theta& theta0);

struct TrainReport {
  double held_out_rmse = 0.0;  // mean over held-out functions, averaged weights
  double elapsed_s = 0.0;
  double samples_per_s = 0.0;
};

// Runs from state.step to options.steps; calls save() at every checkpoint and at the end.
// throws   NumericalError when the loss or the gradient's norm stops being finite; the last checkpoint stays
TrainReport train(const TrainOptions& options, const Representation& representation, const TrainingData& training,
                  const TrainingData& held_out, TrainingState* state, const std::function<void()>& save);

// Mean over functions of the RMSE over all valid support points, for at most `limit` functions taken at equal distances.
double meanRmse(GeneratorNetwork& network, const Representation& representation, const TrainingData& data, int limit);

// Coefficients of functions as they stand (not mirrored): B x K.
torch::Tensor coefficientBatch(const TrainingData& data, const std::vector<Sample>& samples);

}  // namespace nlg
