#include "train/generator/trainer.h"

#include <torch/nn/utils/clip_grad.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "runtime_eval/fit/direct.h"
#include "tool/error.h"
#include "tool/progress.h"
#include "train/generator/function_loss.h"

namespace nlg {
namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// average += (1 - decay) * (network - average); the decay grows from nothing, so that the start is forgotten.
void updateAverage(GeneratorNetwork& average, const GeneratorNetwork& network, double decay, int64_t step) {
  torch::NoGradGuard guard;
  const double used = std::min(decay, (1.0 + step) / (10.0 + step));
  std::vector<torch::Tensor> targets = average->parameters(), sources = network->parameters();
  for (size_t i = 0; i < targets.size(); ++i) targets[i].lerp_(sources[i], 1.0 - used);
}

void setRate(torch::optim::Adam& optimizer, double rate) {
  for (auto& group : optimizer.param_groups()) static_cast<torch::optim::AdamOptions&>(group.options()).lr(rate);
}

void requireFinite(double value, int64_t step, const char* quantity) {
  if (!std::isfinite(value)) throw NumericalError("train", "step " + std::to_string(step), quantity, value);
}

// One step; returns its loss.
double trainStep(const TrainOptions& options, const Representation& representation, const TrainingData& data, SampleOrder& order,
                 TrainingState& state) {
  const std::vector<Sample> samples = order.samples(state.step);
  const torch::Tensor theta = state.network->forward(coefficientBatch(data, samples));
  const torch::Tensor losses = functionLoss(theta, representation, data, samples);
  const torch::Tensor loss = (losses + 1e-6).pow(options.error_power).mean();
  const double value = loss.item<double>();
  requireFinite(value, state.step, "loss");
  state.optimizer->zero_grad();
  loss.backward();
  const double norm = torch::nn::utils::clip_grad_norm_(state.network->parameters(), options.gradient_clip);
  requireFinite(norm, state.step, "norm of the gradient");
  setRate(*state.optimizer, oneCycleRate(options, state.step));
  state.optimizer->step();
  ++state.step;
  updateAverage(state.average, state.network, options.average_decay, state.step);
  return value;
}

}  // namespace

void describeTrainOptions(TrainOptions& o, OptionTable& table) {
  table.add("seed", &o.seed, "seed of every random choice");
  table.add("steps", &o.steps, "training steps", 1, 100000000);
  table.add("batch", &o.batch, "functions a step", 1, 65536);
  table.add("learning_rate", &o.learning_rate, "peak of the one-cycle schedule", 1e-9, 1e3);
  table.add("warmup_share", &o.warmup_share, "share of the steps over which the rate rises", 0.0, 1.0);
  table.add("gradient_clip", &o.gradient_clip, "largest norm of the gradient", 1e-9, 1e9);
  table.add("average_decay", &o.average_decay, "decay of the averaged weights", 0.0, 0.999999);
  table.add("error_power", &o.error_power, "0.5 trains on RMSE, 1 on MSE (more weight to the tail)", 0.1, 4.0);
  table.add("representation_slope", &o.representation_slope, "LeakyReLU slope of the tiny network", 1e-6, 0.9);
  table.add("width", &o.shape.width, "width of the generator's hidden layers", 1, 8192);
  table.add("layers", &o.shape.layer_count, "layers of the generator, the last one included", 1, 32);
  table.add("generator_slope", &o.shape.slope, "LeakyReLU slope of the generator", 1e-6, 0.9);
  table.add("output_scale", &o.shape.output_scale, "factor of the last layer's output", 1e-6, 1e3);
  table.add("start_candidates", &o.start.candidates, "random starts tried for theta0", 1, 1000000);
  table.add("checkpoint_steps", &o.checkpoint_steps, "steps between checkpoints", 1, 100000000);
  table.add("validation_functions", &o.validation_functions, "held-out functions in the validation loss", 1, 100000000);
  table.add("threads", &o.threads, "threads; resuming repeats a run bit for bit at the same number", 1, 1024);
}

double oneCycleRate(const TrainOptions& options, int64_t step) {
  const double position = static_cast<double>(step) / options.steps;
  if (position < options.warmup_share) {
    return options.learning_rate * (0.04 + 0.96 * position / options.warmup_share);
  }
  const double phase = (position - options.warmup_share) / std::max(1e-9, 1.0 - options.warmup_share);
  return options.learning_rate * (1e-4 + (1.0 - 1e-4) * 0.5 * (1.0 + std::cos(M_PI * phase)));
}

Theta fitTheta0(const Representation& representation, const BasisFile& basis, const StartOptions& options) {
  NormalEquationsKernel kernel;
  // `mlp` has to make the tent itself, and most functions are nearly that; the others have it for nothing
  if (representation.kind == RepresentationKind::mlp) return fitStart(representation, tentFunction(), options, &kernel).theta;
  const std::vector<float> phi(basis.mean_function.begin(), basis.mean_function.end());
  std::vector<bool> known;
  for (const auto share : basis.mean_validity) known.push_back(share > 0);
  const WeightingFunction mean = functionFromSamples(phi, known, pointOrder(representation));
  return fitStart(representation, mean, options, &kernel).theta;
}

TrainingState makeState(const TrainOptions& options, const Theta& theta0) {
  TrainingState state;
  state.network = GeneratorNetwork(options.shape, theta0, options.seed);
  state.average = GeneratorNetwork(options.shape, theta0, options.seed);
  state.optimizer = std::make_shared<torch::optim::Adam>(state.network->parameters(),
                                                         torch::optim::AdamOptions(options.learning_rate).betas({0.9, 0.99}));
  state.log_csv = "step,learning_rate,training_loss,held_out_rmse\n";
  return state;
}

torch::Tensor coefficientBatch(const TrainingData& data, const std::vector<Sample>& samples) {
  torch::Tensor batch = torch::empty({static_cast<int64_t>(samples.size()), data.coefficientCount()});
  float* row = batch.data_ptr<float>();
  for (const Sample& sample : samples) {
    data.copyCoefficients(sample.function, sample.mirror, row);
    row += data.coefficientCount();
  }
  return batch;
}

double meanRmse(GeneratorNetwork& network, const Representation& representation, const TrainingData& data, int limit) {
  torch::NoGradGuard guard;
  const int64_t count = std::min<int64_t>(limit, data.functionCount());
  double sum = 0.0;
  for (int64_t begin = 0; begin < count; begin += kBatchCount) {
    std::vector<Sample> samples;
    for (int64_t i = begin; i < std::min<int64_t>(begin + kBatchCount, count); ++i)
      samples.push_back({i * data.functionCount() / count});
    const torch::Tensor theta = network->forward(coefficientBatch(data, samples)).contiguous();
    for (size_t i = 0; i < samples.size(); ++i) {
      sum += functionRmse(representation, decodeFunction(data.function(samples[i].function), pointOrder(representation)),
                          theta.data_ptr<float>() + i * representation.thetaCount());
    }
  }
  return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

TrainReport train(const TrainOptions& options, const Representation& representation, const TrainingData& training,
                  const TrainingData& held_out, TrainingState* state, const std::function<void()>& save) {
  SampleOrder order(training.functionCount(), options.batch, pointOrder(representation).batchCount(), options.seed);
  Progress progress("steps", options.steps);
  TrainReport report;
  const Clock::time_point start = Clock::now();
  const int64_t first_step = state->step;
  double loss_sum = 0.0, training_s = 0.0;
  int64_t loss_count = 0;
  while (state->step < options.steps) {
    const Clock::time_point step_start = Clock::now();
    loss_sum += trainStep(options, representation, training, order, *state);
    ++loss_count;
    training_s += secondsSince(step_start);
    progress.update(state->step, "loss " + std::to_string(loss_sum / static_cast<double>(loss_count)));
    if (state->step % options.checkpoint_steps != 0 && state->step != options.steps) continue;
    report.held_out_rmse = meanRmse(state->average, representation, held_out, options.validation_functions);
    requireFinite(report.held_out_rmse, state->step, "held-out error");
    state->log_csv += std::to_string(state->step) + ',' + std::to_string(oneCycleRate(options, state->step - 1)) + ',' +
                      std::to_string(loss_sum / static_cast<double>(loss_count)) + ',' + std::to_string(report.held_out_rmse) +
                      '\n';
    loss_sum = 0.0, loss_count = 0;
    save();
  }
  // a run that had been finished already took no step here
  if (first_step == state->step) {
    report.held_out_rmse = meanRmse(state->average, representation, held_out, options.validation_functions);
  }
  report.elapsed_s = secondsSince(start);
  report.samples_per_s = training_s > 0 ? static_cast<double>((state->step - first_step) * options.batch) / training_s : 0.0;
  return report;
}

}  // namespace nlg
