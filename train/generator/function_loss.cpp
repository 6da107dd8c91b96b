#include "train/generator/function_loss.h"

#include <ATen/Parallel.h>

#include "runtime_eval/fit/last_layer.h"
#include "runtime_eval/fit/loss_kernel.h"

namespace nlg {
namespace {

constexpr int64_t kSamplesATask = 8;

// The points of a sample as the kernels read them.
struct DecodedSample {
  int first = 0, count = 0, valid_count = 0;  // places of the point order
  AlignedFloats phi, mask;

  void decode(const PointOrder& order, const TrainingData& data, const Sample& sample) {
    const int end = sample.batch + sample.batch_count;
    first = order.batch_begin[sample.batch];
    count = order.batch_begin[end] - first;
    phi.resize(count);
    mask.resize(count);
    valid_count = 0;
    for (int batch = sample.batch; batch < end; ++batch) {
      const int offset = order.batch_begin[batch] - first;
      valid_count += decodeBatch(order, batch, data.function(sample.function), sample.mirror, &phi[offset], &mask[offset]);
    }
  }
};

// Calls visit(b, decoded sample b) for every sample, on libtorch's threads.
template <class Visit>
void forEachSample(const Representation& representation, const TrainingData& data, const std::vector<Sample>& samples,
                   const Visit& visit) {
  const PointOrder& order = pointOrder(representation);
  at::parallel_for(0, static_cast<int64_t>(samples.size()), kSamplesATask, [&](int64_t begin, int64_t end) {
    thread_local DecodedSample decoded;
    for (int64_t b = begin; b < end; ++b) {
      decoded.decode(order, data, samples[b]);
      visit(b, decoded);
    }
  });
}

}  // namespace

ThetaErrors measureTheta(const torch::Tensor& theta, const Representation& representation, const TrainingData& data,
                         const std::vector<Sample>& samples) {
  const torch::Tensor values = theta.detach().contiguous();
  const int64_t count = values.size(0), D = values.size(1);
  ThetaErrors errors{torch::empty({count}), torch::empty({count, D})};
  const float* theta_values = values.data_ptr<float>();
  float* mean_squares = errors.mean_square.data_ptr<float>();
  float* gradients = errors.gradient.data_ptr<float>();
  forEachSample(representation, data, samples, [&](int64_t b, const DecodedSample& sample) {
    float* gradient = gradients + b * D;
    const double sum = lossAndGradient(representation, sample.first, sample.count, sample.phi.data(), sample.mask.data(),
                                       theta_values + b * D, gradient);
    const float scale = sample.valid_count > 0 ? 1.0f / static_cast<float>(sample.valid_count) : 0.0f;
    mean_squares[b] = static_cast<float>(sum) * scale;
    for (int64_t d = 0; d < D; ++d) gradient[d] *= scale;
  });
  return errors;
}

torch::Tensor differentiable(const ThetaErrors& errors, const torch::Tensor& theta) {
  return errors.mean_square + (errors.gradient * (theta - theta.detach())).sum(1);
}

torch::Tensor solveLastLayers(const torch::Tensor& theta, const Representation& representation, const TrainingData& data,
                              const std::vector<Sample>& samples) {
  torch::Tensor solved = theta.detach().clone(torch::MemoryFormat::Contiguous);
  const int64_t D = solved.size(1);
  float* values = solved.data_ptr<float>();
  forEachSample(representation, data, samples, [&](int64_t b, const DecodedSample& sample) {
    solveLastLayer(representation, sample.first, sample.count, sample.phi.data(), sample.mask.data(), values + b * D);
  });
  const int64_t last = representation.shape().w3();
  return torch::cat({theta.slice(1, 0, last), solved.slice(1, last)}, 1);
}

}  // namespace nlg
