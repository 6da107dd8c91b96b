#include "train/generator/theta_stages.h"

#include "train/generator/dictionary_loss.h"

#include "runtime_eval/evaluator/kernel_shape.h"
#include "tool/parallel_for.h"

namespace nlg {

ThetaStages runStages(GeneratorNetwork& network, const Representation& representation, const TrainingData& data,
                      const std::vector<Sample>& samples, const LossOptions& loss) {
  const torch::Device device = network->parameters().front().device();
  torch::Tensor theta = network->forward(coefficientBatch(data, samples).to(device)).cpu();
  if (representation.isCode()) return {{codeMeanSquares(network, theta, data, samples, -1, {.loss = loss})}};
  const SampleTargets targets(representation, data, samples, loss);
  ThetaStages stages;
  const auto measure = [&] { stages.mean_squares.push_back(differentiable(measureTheta(theta, targets), theta)); };
  measure();
  if (network->solvesLastLayer(representation)) {
    theta = solveLastLayers(theta, targets);
    measure();
  }
  return stages;
}

HeldOutError heldOutError(GeneratorNetwork& network, const Representation& representation, const TrainingData& data,
                          const LossOptions& loss, int limit, double tent_rmse, int thread_count) {
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
    const ThetaStages stages = runStages(network, representation, data, samples, loss);
    const torch::Tensor least = std::get<0>(torch::stack(stages.mean_squares).min(0));
    sums[part] = {stages.mean_squares.front().sqrt().sum().item<double>(), least.sqrt().sum().item<double>()};
    for (const Sample& sample : samples) sums[part].tent += tentRmse(data.function(sample.function));
  });
  HeldOutError error;
  for (const HeldOutError& sum : sums) error.network += sum.network, error.final += sum.final, error.tent += sum.tent;
  for (double* value : {&error.network, &error.final, &error.tent}) *value /= static_cast<double>(count);
  return error;
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

}  // namespace nlg
