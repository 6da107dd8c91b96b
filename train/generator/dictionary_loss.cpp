#include "train/generator/dictionary_loss.h"

#include <algorithm>

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
  if (options.leak > 0.0) {
    const torch::Tensor held = logits.detach();
    const torch::Tensor follows = torch::logical_or(held.abs() < kFarLogit, residuals.detach() * held > 0).to(torch::kFloat);
    residuals = residuals + follows * (options.leak * tents * targets.mask) * (logits - held);
  }
  return residuals.square().sum(1) / targets.valid_counts;
}

}  // namespace nlg
