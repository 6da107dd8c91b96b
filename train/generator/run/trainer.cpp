#include "train/generator/run/trainer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <fmt/format.h>

#include "runtime_eval/evaluator/kernel_shape.h"
#include "tool/error.h"
#include "tool/progress.h"
#include "train/generator/run/loss_guard.h"

namespace nlg {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int64_t kStepsBetweenGoodStates = 100;

// A batch is computed in parts of so many samples, each on one thread: enough for the matrix products to be at their best, and few enough
// for what a layer leaves to stay in the cache. Two parts at least, and no more than kMostParts, since each has a gradient of its own.
constexpr int kSamplesAPart = 256, kMostParts = 16;

struct LossMean {
  double sum = 0.0;
  int64_t count = 0;

  void add(double loss) { sum += loss, ++count; }
  double value() const { return count > 0 ? sum / static_cast<double>(count) : 0.0; }
};

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// How far the averaged weights follow; all the way at first, so that the start is forgotten.
double averageShare(const TrainOptions& options, int64_t step) {
  const double count = static_cast<double>(step);
  return 1.0 - std::min(options.average_decay, (1.0 + count) / (10.0 + count));
}

// A rollback halves what the schedule says.
double scheduledRate(const TrainOptions& options, const TrainingState& state, int64_t step) {
  return std::ldexp(oneCycleRate(options, step), -state.rollbacks);
}

void requireFinite(double value, int64_t step, const char* quantity) {
  if (!std::isfinite(value)) throw NumericalError("train", "step " + std::to_string(step), quantity, value);
}

// No loss of a stage counts for more: phi is within [0, 1], and a theta that is further off than by 1 wherever that costs most has gone
// astray. One such theta in a million would otherwise decide a whole step.
double largestLoss(const TrainOptions& options) {
  return std::pow(std::max(options.loss.dark_weight, std::pow(options.loss.blend_floor, -2.0)), options.error_power);
}

// Dark points count as much as lit ones at the first step and their whole weight at the last, and grow by equal factors: held against walls
// from the start, sigmoids shut where light is yet to be learned, and fits start badly there (docs/lab/training.md).
LossOptions lossAt(const TrainOptions& options, int64_t step) {
  if (options.begins_trained) return options.loss;
  return {std::pow(options.loss.dark_weight, static_cast<double>(step) / options.steps), options.loss.blend_floor};
}

// Of the sigmoid's slope where a point is shut, at the start; it falls to 0 at kLeakEnd of the steps.
constexpr double kStartLeak = 0.25, kLeakEnd = 0.8;

// Loss of each sample's code, at one batch of points for all of them.
torch::Tensor codeLosses(const TrainOptions& options, const TrainingData& data, const std::vector<Sample>& samples,
                         TrainingState& state) {
  const torch::Device device = state.network->parameters().front().device();
  const torch::Tensor z = state.network->forward(inputBatch(data, samples).to(device)).cpu();
  const double phase = options.begins_trained ? 1.0 : static_cast<double>(state.step) / options.steps;
  const DictionaryLossOptions loss{kStartLeak * std::max(0.0, 1.0 - phase / kLeakEnd), lossAt(options, state.step)};
  const torch::Tensor mean_squares = codeMeanSquares(state.network, z, data, samples, samples.front().batch, loss);
  return (mean_squares + 1e-6).pow(options.error_power).clamp_max(largestLoss(options));
}

// Loss of each sample: the mean over the stages of its theta.
torch::Tensor stepLosses(const TrainOptions& options, const Representation& representation, const TrainingData& data,
                         const std::vector<Sample>& samples, TrainingState& state) {
  if (representation.isCode()) return codeLosses(options, data, samples, state);
  const std::vector<torch::Tensor> stages = runStages(state.network, representation, data, samples, lossAt(options, state.step));
  return (torch::stack(stages) + 1e-6).pow(options.error_power).clamp_max(largestLoss(options)).mean(0);
}

// One of `count` shares of the samples.
std::vector<Sample> shareOf(const std::vector<Sample>& samples, int index, int count) {
  const auto border = [&](int at) { return samples.begin() + static_cast<ptrdiff_t>(at * samples.size() / count); };
  return {border(index), border(index + 1)};
}

// The processes start alike: at the same step, with the first one's networks.
void agree(const TrainingState& state, const ProcessGroup& processes) {
  if (processes.count() == 1) return;
  torch::NoGradGuard guard;
  // each process writes its step into its own place, so that the sum is everybody's
  torch::Tensor steps = torch::zeros({processes.count()}, torch::kDouble);
  steps[processes.rank()] = static_cast<double>(state.step);
  processes.sum(steps);
  for (int rank = 0; rank < processes.count(); ++rank) {
    if (steps[rank].item<double>() != static_cast<double>(state.step)) {
      throw InputError("--run", "process " + std::to_string(rank),
                       "the same checkpoint in all processes, of step " + std::to_string(state.step),
                       "step " + std::to_string(steps[rank].item<int64_t>()));
    }
  }
  // the numbers of process 0: all others add zeros
  for (const GeneratorNetwork& network : {state.network, state.average}) {
    std::vector<torch::Tensor> tensors = network->parameters();
    for (const torch::Tensor& buffer : network->buffers()) tensors.push_back(buffer);
    for (torch::Tensor& tensor : tensors) {
      torch::Tensor values = tensor.detach().cpu().clone().contiguous();
      if (processes.rank() != 0) values.zero_();
      processes.sum(values);
      tensor.copy_(values);
    }
  }
}

std::string logLine(const TrainOptions& options, const TrainingState& state, double loss, const HeldOutError& held_out) {
  // rates end at a ten-thousandth of the peak: six digits of each number, not six decimals
  const auto text = [](double value) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.6g", value);
    return std::string(digits);
  };
  return std::to_string(state.step) + ',' + text(scheduledRate(options, state, state.step - 1)) + ',' + text(loss) + ',' +
         text(held_out.network) + ',' + text(held_out.final) + ',' + text(held_out.tent) + ',' + std::to_string(state.rollbacks) +
         '\n';
}

SampleOrder sampleOrder(const TrainOptions& options, const Representation& representation, const TrainingData& training) {
  std::vector<uint32_t> with_theta;
  if (options.theta_share > 0) with_theta = training.functionsAbove(options.bare_tent_rmse);
  // codes are fitted cell by cell, but trained on strata
  const int batch_count = representation.isCode() ? kStratumCount : pointOrder(representation).batchCount();
  return SampleOrder(training.functionCount(), std::move(with_theta),
                     {.batch = options.batch,
                      .point_batch_count = batch_count,
                      .point_batches = std::min(options.point_batches, batch_count),
                      .visibility_share = options.input == "samples" ? options.visibility_share : 0.0,
                      .part_share = options.theta_share,
                      .seed = options.seed});
}

}  // namespace

void describeTrainOptions(TrainOptions& o, OptionTable& table) {
  table.group("Training");
  table.add("seed", &o.seed, "seed of every random choice");
  table.add("steps", &o.steps, "training steps", 1, 100000000);
  table.add("batch", &o.batch, "functions per step", 1, 65536);
  table.add("learning_rate", &o.learning_rate, "peak learning rate of the one-cycle schedule", 1e-9, 1e3);
  table.add("warmup_share", &o.warmup_share, "share of the steps during which the learning rate rises", 0.0, 1.0);
  table.add("gradient_clip", &o.gradient_clip, "maximum norm of the gradient", 1e-9, 1e9);
  table.add("average_decay", &o.average_decay, "decay per step of the averaged weights", 0.0, 0.999999);
  table.add("error_power", &o.error_power,
            "exponent of each function's loss: 0.5 trains on blend RMSE; 1 weighs large errors more", 0.1, 4.0);
  table.add("point_batches", &o.point_batches,
            "eighths of the support points on which a sample's loss is computed, for networks: 1, 2, 4 or 8", 1, 8);
  table.add(
      "input", &o.input,
      "what the generator reads of a function: samples, its values, visibility and validity at 1,024 points; or coefficients, "
      "on the principal components of its values at all points",
      {"samples", "coefficients"});
  table.add("coefficients", &o.coefficients,
            "number of coefficients used, those of largest variance; of samples, number of trained components, an eighth in each "
            "parity class. 0: as many as the basis has",
            0, kSupportPointCount);
  table.add("visibility_share", &o.visibility_share,
            "samples: share of each batch whose input is what the probe sees, as in a draft, in place of the function", 0.0, 1.0);
  table.add("whitening", &o.whitening,
            "exponent of whitening: 1 scales every coefficient to standard deviation 1; 0 scales all by one factor", 0.0, 1.0);
  table.add("theta_share", &o.theta_share,
            "share of each batch drawn only from functions that take a theta; the rest is drawn from all", 0.0, 0.99);
  table.add("bare_tent_rmse", &o.bare_tent_rmse, "maximum blend RMSE of the bare tent at which a function takes no theta", 0.0,
            1.0);
  table.add("divergence_ratio", &o.divergence_ratio,
            "ratio of the loss to its running median above which training returns to its last good state", 1.0, 1e9);
  table.add(
      "dark_weight", &o.loss.dark_weight,
      "the loss: weight of squared residuals where the function is 0 and the tent is not; reached at the last step of training",
      1.0, 1e6);
  table.add("blend_floor", &o.loss.blend_floor,
            "the loss: lower bound of the blend's sum of functions, by whose inverse square all other residuals are weighted",
            1e-3, 1.0);
  table.group("Networks");
  table.add("representation_slope", &o.representation_slope, "LeakyReLU slope of the tiny network", 1e-6, 0.9);
  table.add("width", &o.shape.width, "width of the generator's hidden layers", 1, 8192);
  table.add("layers", &o.shape.layer_count, "number of the generator's layers, the last one included", 1, 32);
  table.add("generator_slope", &o.shape.slope, "LeakyReLU slope of the generator", 1e-6, 0.9);
  table.add("output_scale", &o.shape.output_scale, "factor on the last layer's output", 1e-6, 1e3);
  table.add("exact_last_layer", &o.shape.exact_last_layer,
            "solve the last layer exactly after the generator, for networks with a linear output");
  table.add("dictionary_resolution", &o.shape.dictionary_resolution,
            "codes: nodes of the dictionary along each axis: 3, 5, 7 or 9", 3, 9);
  table.group("Run");
  table.add("start_candidates", &o.start.candidates, "number of random starts tried for theta0", 1, 1000000);
  table.add("checkpoint_steps", &o.checkpoint_steps,
            "number of steps between checkpoints, each with a validation. 0: a twentieth of the steps", 0, 100000000);
  table.add("validation_functions", &o.validation_functions, "number of held-out functions in the validation loss", 1, 100000000);
  table.add("threads", &o.threads, "number of threads; a batch of up to 512 keeps two busy. The result does not depend on it", 1,
            1024);
}

BasisData usedBasis(const TrainOptions& options, const Basis& basis) {
  if (options.input == "samples") {
    const int asked = options.coefficients == 0 ? basis.data.coefficientCount() : options.coefficients;
    const int in_class = std::max(1, asked / kParityClassCount);
    BasisData trained{.input = GeneratorInput::samples};
    trained.class_count.fill(in_class);
    trained.deviation.assign(size_t(in_class) * kParityClassCount, 1.0f);
    return trained;
  }
  return whitened(options.coefficients == 0 ? basis.data : truncateBasis(basis, options.coefficients).data, options.whitening);
}

double oneCycleRate(const TrainOptions& options, int64_t step) {
  // a warm-up from .04 of the peak, then a cosine down to 1e-4 of it (docs/theory/math.md §6)
  const double position = static_cast<double>(step) / options.steps;
  if (position < options.warmup_share) {
    return options.learning_rate * (0.04 + 0.96 * position / options.warmup_share);
  }
  const double phase = (position - options.warmup_share) / std::max(1e-9, 1.0 - options.warmup_share);
  return options.learning_rate * (1e-4 + (1.0 - 1e-4) * 0.5 * (1.0 + std::cos(std::numbers::pi * phase)));
}

Theta fitTheta0(const Representation& representation, const BasisFile& basis, const StartOptions& options) {
  // the dictionary's c, which is trained, is where codes begin
  if (representation.isCode()) return Theta(representation.thetaCount());
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
  state.network->to(options.device);
  state.average->to(options.device);
  state.moments = zeroMoments(state.network);
  state.log_csv =
      "step,learning_rate,training_loss,held_out_network_blend_rmse,held_out_blend_rmse,bare_tent_blend_rmse,rollbacks\n";
  return state;
}

TrainStep::TrainStep(const TrainOptions& options, const Representation& representation, const TrainingData& training,
                     const TrainingState& state, const ProcessGroup& processes)
    : options_(options),
      representation_(representation),
      training_(training),
      processes_(processes),
      order_(sampleOrder(options, representation, training)),
      gradient_(state.network) {
  if (training.cache() != nullptr) loader_ = std::make_unique<WindowLoader>(*training.cache(), order_, state.draw);
}

TrainStep::Result TrainStep::computeGradient(TrainingState& state) {
  if (loader_) loader_->require(state.draw);
  const std::vector<Sample> batch = order_.samples(state.draw++);
  // a process takes its share of the batch, a thread its parts of that; the gradient is over all of it
  const std::vector<Sample> share = shareOf(batch, processes_.rank(), processes_.count());
  const int sample_count = static_cast<int>(share.size());
  const int part_count = std::min(std::clamp((sample_count + kSamplesAPart - 1) / kSamplesAPart, 2, kMostParts), sample_count);
  gradient_.compute(state.network, part_count, options_.threads, [&](int part) {
    return stepLosses(options_, representation_, training_, shareOf(share, part, part_count), state).sum() /
           static_cast<double>(batch.size());
  });
  if (processes_.count() > 1) processes_.sum(gradient_.row());
  gradient_norm_ = gradient_.norm();
  return {gradient_.loss(), gradient_norm_};
}

void TrainStep::apply(TrainingState& state, double rate) {
  ++state.step;
  takeStep({state.step, rate, gradient_norm_, options_.gradient_clip, averageShare(options_, state.step)}, gradient_,
           options_.threads, state.network, state.moments, state.average);
}

TrainReport train(const TrainOptions& options, const Representation& representation, const TrainingData& training,
                  const TrainingData& held_out, TrainingState* state, const std::function<void()>& save,
                  const ProcessGroup& processes) {
  agree(*state, processes);
  TrainStep step(options, representation, training, *state, processes);
  LossGuard guard(*state, options.divergence_ratio);
  Progress progress("steps", options.steps);
  progress.setDoneBefore(state->step);
  TrainReport report;
  const Clock::time_point start = Clock::now();
  const int64_t first_step = state->step, first_draw = state->draw;
  const int checkpoint_steps = options.checkpoint_steps > 0 ? options.checkpoint_steps : std::max(1, options.steps / 20);
  double training_s = 0.0;
  LossMean mean, kept_mean;  // since the last checkpoint
  const auto goBack = [&](const char* quantity, double value) {
    guard.rollBack(state, quantity, value);
    mean = kept_mean;
  };
  const auto judge = [&] {
    return heldOutError(state->average, representation, held_out, options.loss, options.validation_functions,
                        options.bare_tent_rmse, options.threads);
  };
  while (state->step < options.steps) {
    const Clock::time_point step_start = Clock::now();
    const TrainStep::Result result = step.computeGradient(*state);
    training_s += secondsSince(step_start);
    // a batch that diverged is not applied: back to the last good state
    if (!guard.accepts(*state, result.loss, result.gradient_norm)) {
      if (std::isfinite(result.gradient_norm))
        goBack("loss", result.loss);
      else
        goBack("norm of the gradient", result.gradient_norm);
      continue;
    }
    const Clock::time_point apply_start = Clock::now();
    step.apply(*state, scheduledRate(options, *state, state->step));
    noteLoss(state, result.loss);
    mean.add(result.loss);
    training_s += secondsSince(apply_start);
    if (progress.due()) {
      const double rate = scheduledRate(options, *state, state->step - 1);
      progress.update(state->step, fmt::format("loss {:.4g}, learning rate {:.2g}", mean.value(), rate));
    }
    // good states between checkpoints keep the way back short
    const bool at_checkpoint = state->step % checkpoint_steps == 0 || state->step == options.steps;
    if (!at_checkpoint && state->step % kStepsBetweenGoodStates != 0) continue;
    if (!guard.keep(*state)) {
      goBack("sum of the parameters", NAN);
      continue;
    }
    kept_mean = mean;
    if (!at_checkpoint) continue;
    // networks are alike in all processes: the first one judges and writes
    if (processes.rank() == 0) {
      report.held_out = judge();
      requireFinite(report.held_out.final, state->step, "held-out error");
      state->log_csv += logLine(options, *state, mean.value(), report.held_out);
      save();
    }
    mean = kept_mean = {};
  }
  // a run that had been finished already took no step here
  if (first_step == state->step && processes.rank() == 0) {
    report.held_out = judge();
  }
  report.elapsed_s = secondsSince(start);
  report.samples_per_s = training_s > 0 ? static_cast<double>((state->draw - first_draw) * options.batch) / training_s : 0.0;
  return report;
}

}  // namespace nlg
