#include "train/generator/network/theta_stages.h"

#include <algorithm>

#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/fit/last_layer.h"
#include "runtime_eval/fit/loss/loss_kernel.h"
#include "runtime_eval/numbers/flush_subnormals.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

// Beyond, a gradient that leads further out is not followed.
constexpr double kFarLogit = 6.0;

// Places of the stratum order.
struct Places {
  int first, count;
};

torch::Tensor tentsOf(const Places& places) {
  const PointSet& points = stratumOrder().points;
  torch::Tensor tents = torch::empty({places.count});
  std::copy_n(&points.tent[places.first], places.count, tents.data_ptr<float>());
  return tents;
}

// phi and the mask of all samples at some places, B x places.
struct Targets {
  torch::Tensor phi, mask, valid_counts;
};

Targets targetsOf(const TrainingData& data, const std::vector<Sample>& samples, int first_batch, int batch_count,
                  const LossOptions& loss) {
  const PointOrder& order = stratumOrder();
  const int first = order.batch_begin[first_batch], count = order.batch_begin[first_batch + batch_count] - first;
  const auto B = static_cast<int64_t>(samples.size());
  const LossWeights weights(loss);
  Targets targets{torch::empty({B, count}), torch::empty({B, count}), torch::empty({B})};
  for (int64_t b = 0; b < B; ++b) {
    const Sample& sample = samples[static_cast<size_t>(b)];
    float *phi = targets.phi.data_ptr<float>() + b * count, *mask = targets.mask.data_ptr<float>() + b * count;
    int valid = 0;
    for (int batch = first_batch; batch < first_batch + batch_count; ++batch) {
      const int at = order.batch_begin[batch] - first;
      valid += decodeBatch(order, batch, data.function(sample.function), sample.mirror, weights, phi + at, mask + at);
    }
    targets.valid_counts.data_ptr<float>()[b] = static_cast<float>(std::max(1, valid));
  }
  return targets;
}

}  // namespace

torch::Tensor codeMeanSquares(GeneratorNetwork& network, const torch::Tensor& z, const TrainingData& data,
                              const std::vector<Sample>& samples, int point_batch, const DictionaryLossOptions& options) {
  const PointOrder& order = stratumOrder();
  const int first_batch = std::max(0, point_batch), batch_count = point_batch < 0 ? order.batchCount() : 1;
  const int first = order.batch_begin[first_batch];
  const Places places{first, order.batch_begin[first_batch + batch_count] - first};
  const Targets targets = targetsOf(data, samples, first_batch, batch_count, options.loss);
  const torch::Tensor tents = tentsOf(places), table = network->dictionaryAt(order.points, places.first, places.count);
  const int64_t K = z.size(1);
  const torch::Tensor logits = torch::addmm(table.select(1, K), z, table.slice(1, 0, K).t());
  // bytes of functions may lie a rounding above the tent, which no sigmoid reaches
  torch::Tensor residuals = (torch::sigmoid(logits) * tents - torch::minimum(targets.phi, tents)) * targets.mask;
  // a saturated sigmoid passes on a share of a slope, unless that leads further out
  if (options.leak > 0.0) {
    const torch::Tensor held = logits.detach();
    const torch::Tensor follows = torch::logical_or(held.abs() < kFarLogit, residuals.detach() * held > 0).to(torch::kFloat);
    residuals = residuals + follows * (options.leak * tents * targets.mask) * (logits - held);
  }
  return residuals.square().sum(1) / targets.valid_counts;
}

SampleTargets::SampleTargets(const Representation& representation, const TrainingData& data, const std::vector<Sample>& samples,
                             const LossOptions& loss)
    : representation_(representation), places_(samples.size()) {
  const PointOrder& order = pointOrder(representation);
  for (size_t b = 0; b < samples.size(); ++b) {
    const int first = order.batch_begin[samples[b].batch];
    places_[b] = {first, order.batch_begin[samples[b].batch + samples[b].batch_count] - first};
    stride_ = std::max(stride_, static_cast<size_t>(places_[b].count));
  }
  const LossWeights weights(loss);
  phi_.resize(samples.size() * stride_);
  mask_.resize(samples.size() * stride_);
  for (size_t b = 0; b < samples.size(); ++b) {
    const Sample& sample = samples[b];
    for (int batch = sample.batch; batch < sample.batch + sample.batch_count; ++batch) {
      const size_t at = b * stride_ + (order.batch_begin[batch] - places_[b].first);
      places_[b].valid_count +=
          decodeBatch(order, batch, data.function(sample.function), sample.mirror, weights, &phi_[at], &mask_[at]);
    }
  }
}

SampleTargets::Points SampleTargets::of(int64_t sample) const {
  const Places& places = places_[static_cast<size_t>(sample)];
  const size_t at = static_cast<size_t>(sample) * stride_;
  return {places.first, places.count, places.valid_count, &phi_[at], &mask_[at]};
}

ThetaErrors measureTheta(const torch::Tensor& theta, const SampleTargets& targets) {
  const torch::Tensor values = theta.detach().contiguous();
  const int64_t count = values.size(0), D = values.size(1);
  ThetaErrors errors{torch::empty({count}), torch::empty({count, D})};
  const float* theta_values = values.data_ptr<float>();
  float* mean_squares = errors.mean_square.data_ptr<float>();
  float* gradients = errors.gradient.data_ptr<float>();
  const FlushSubnormals flush;
  for (int64_t b = 0; b < count; ++b) {
    const SampleTargets::Points points = targets.of(b);
    float* gradient = gradients + b * D;
    const double sum = lossAndGradient(targets.representation(), points.first, points.count, points.phi, points.mask,
                                       theta_values + b * D, gradient);
    const float scale = points.valid_count > 0 ? 1.0f / static_cast<float>(points.valid_count) : 0.0f;
    mean_squares[b] = static_cast<float>(sum) * scale;
    for (int64_t d = 0; d < D; ++d) gradient[d] *= scale;
  }
  return errors;
}

torch::Tensor differentiable(const ThetaErrors& errors, const torch::Tensor& theta) {
  return errors.mean_square + (errors.gradient * (theta - theta.detach())).sum(1);
}

torch::Tensor solveLastLayers(const torch::Tensor& theta, const SampleTargets& targets) {
  torch::Tensor solved = theta.detach().clone(torch::MemoryFormat::Contiguous);
  const int64_t D = solved.size(1);
  float* values = solved.data_ptr<float>();
  const FlushSubnormals flush;
  for (int64_t b = 0; b < targets.count(); ++b) {
    const SampleTargets::Points points = targets.of(b);
    solveLastLayer(targets.representation(), points.first, points.count, points.phi, points.mask, values + b * D);
  }
  const int64_t last = targets.representation().shape().w3();
  return torch::cat({theta.slice(1, 0, last), solved.slice(1, last)}, 1);
}

std::vector<torch::Tensor> runStages(GeneratorNetwork& network, const Representation& representation, const TrainingData& data,
                                     const std::vector<Sample>& samples, const LossOptions& loss) {
  const torch::Device device = network->parameters().front().device();
  torch::Tensor theta = network->forward(inputBatch(data, samples).to(device)).cpu();
  if (representation.isCode()) return {{codeMeanSquares(network, theta, data, samples, -1, {.loss = loss})}};
  const SampleTargets targets(representation, data, samples, loss);
  std::vector<torch::Tensor> stages;
  // each stage has its term in the loss (docs/theory/math.md §6)
  const auto measure = [&] { stages.push_back(differentiable(measureTheta(theta, targets), theta)); };
  measure();
  if (network->solvesLastLayer(representation)) {
    theta = solveLastLayers(theta, targets);
    measure();
  }
  return stages;
}

HeldOutError heldOutError(GeneratorNetwork& network, const Representation& representation, const TrainingData& data,
                          const LossOptions& loss, int limit, double tent_rmse, int thread_count) {
  // functions that take a theta, at equal distances
  const std::vector<uint32_t> functions = data.functionsAbove(tent_rmse);
  const int64_t function_count = static_cast<int64_t>(functions.size()), count = std::min<int64_t>(limit, function_count);
  if (count == 0) return {};
  const int all_points = pointOrder(representation).batchCount();
  std::vector<HeldOutError> sums(static_cast<size_t>((count + kBatchCount - 1) / kBatchCount));
  parallelFor(sums.size(), thread_count, [&](uint64_t part, int) {
    const torch::NoGradGuard guard;  // of this thread
    const int64_t begin = static_cast<int64_t>(part) * kBatchCount;
    std::vector<Sample> samples;
    for (int64_t i = begin; i < std::min<int64_t>(begin + kBatchCount, count); ++i) {
      samples.push_back({.function = functions[static_cast<size_t>(i * function_count / count)], .batch_count = all_points});
    }
    const std::vector<torch::Tensor> stages = runStages(network, representation, data, samples, loss);
    // the better stage of each function, which a bake would keep
    const torch::Tensor least = std::get<0>(torch::stack(stages).min(0));
    sums[part] = {stages.front().sqrt().sum().item<double>(), least.sqrt().sum().item<double>()};
    for (const Sample& sample : samples) sums[part].tent += tentRmse(data.function(sample.function));
  });
  HeldOutError error;
  for (const HeldOutError& sum : sums) error.network += sum.network, error.final += sum.final, error.tent += sum.tent;
  for (double* value : {&error.network, &error.final, &error.tent}) *value /= static_cast<double>(count);
  return error;
}

torch::Tensor inputBatch(const TrainingData& data, const std::vector<Sample>& samples) {
  torch::Tensor batch = torch::empty({static_cast<int64_t>(samples.size()), data.inputCount()});
  float* row = batch.data_ptr<float>();
  for (const Sample& sample : samples) {
    data.copyInput(sample, row);
    row += data.inputCount();
  }
  return batch;
}

}  // namespace nlg
