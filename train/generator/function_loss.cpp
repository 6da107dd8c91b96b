#include "train/generator/function_loss.h"

#include <algorithm>

#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/fit/last_layer.h"
#include "runtime_eval/fit/loss_kernel.h"
#include "runtime_eval/numbers/flush_subnormals.h"

namespace nlg {

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

}  // namespace nlg
