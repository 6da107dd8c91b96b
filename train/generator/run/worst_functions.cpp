#include "train/generator/run/worst_functions.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <nlohmann/json.hpp>

#include "nlg/support.h"
#include "runtime_eval/evaluator/evaluate.h"

namespace nlg {
namespace {

constexpr int64_t kMostJudged = 256, kAtOnce = 32;
constexpr float kHalfThickness = 0.12f;

const PointSet& supportPoints() {
  static const PointSet points = makePointSet(supportPattern().points);
  return points;
}

// The representation at all support points.
AlignedFloats valuesOf(GeneratorNetwork& network, const Representation& representation, const torch::Tensor& theta) {
  const PointSet& points = supportPoints();
  AlignedFloats values(static_cast<size_t>(points.padded_count));
  if (!representation.isCode()) {
    evaluate(representation, points, theta.contiguous().data_ptr<float>(), values.data());
    return values;
  }
  const torch::Tensor table = network->dictionaryAt(points, 0, points.count);
  const int64_t K = theta.numel();
  const torch::Tensor shares = torch::sigmoid(torch::addmv(table.select(1, K), table.slice(1, 0, K), theta)).contiguous();
  for (int i = 0; i < points.count; ++i) values[i] = shares.data_ptr<float>()[i] * points.tent[i];
  return values;
}

// Least loss of each sample, and whether it is that of the solved last layer.
std::tuple<torch::Tensor, torch::Tensor> leastLosses(GeneratorNetwork& network, const Representation& representation,
                                                     const TrainingData& held_out, const std::vector<Sample>& samples,
                                                     const LossOptions& loss) {
  return torch::stack(runStages(network, representation, held_out, samples, loss)).min(0);
}

// As many digits as a picture shows.
double rounded(float value) { return std::round(1e4 * value) / 1e4; }

// The plane through the probe in which two functions differ most.
void takePlane(const StoredFunction& function, const AlignedFloats& values, WorstFunction* worst) {
  double largest = -1.0;
  for (int axis = 0; axis < 3; ++axis) {
    double sum = 0.0;
    std::vector<WorstFunction::Point> near;
    for (size_t i = 0; i < kSupportPointCount; ++i) {
      const LocalPoint& place = supportPattern().points[i];
      if (std::abs(place[axis]) > kHalfThickness || !function.isValid(i)) continue;
      near.push_back({place[(axis + 1) % 3], place[(axis + 2) % 3], static_cast<float>(function.phi[i]) / 255.0f, values[i]});
      sum += std::abs(near.back().target - near.back().predicted);
    }
    const double mean = sum / static_cast<double>(std::max<size_t>(1, near.size()));
    if (mean <= largest) continue;
    largest = mean;
    worst->axis = axis;
    worst->points = std::move(near);
  }
}

}  // namespace

std::vector<WorstFunction> worstFunctions(GeneratorNetwork& network, const Representation& representation,
                                          const TrainingData& held_out, const TrainOptions& options, size_t count) {
  const torch::NoGradGuard guard;
  const std::vector<uint32_t> functions = held_out.functionsAbove(options.bare_tent_rmse);
  const auto all = static_cast<int64_t>(functions.size()), judged = std::min(kMostJudged, all);
  const int batch_count = pointOrder(representation).batchCount();
  std::vector<std::pair<double, Sample>> losses;
  for (int64_t begin = 0; begin < judged; begin += kAtOnce) {
    std::vector<Sample> samples;
    for (int64_t i = begin; i < std::min(begin + kAtOnce, judged); ++i)
      samples.push_back({.function = functions[static_cast<size_t>(i * all / judged)], .batch_count = batch_count});
    const torch::Tensor least = std::get<0>(leastLosses(network, representation, held_out, samples, options.loss));
    for (size_t i = 0; i < samples.size(); ++i) losses.emplace_back(least[static_cast<int64_t>(i)].item<double>(), samples[i]);
  }
  count = std::min(count, losses.size());
  std::partial_sort(losses.begin(), losses.begin() + static_cast<std::ptrdiff_t>(count), losses.end(),
                    [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<WorstFunction> worst(count);
  for (size_t i = 0; i < count; ++i) {
    const std::vector<Sample> sample{losses[i].second};
    torch::Tensor theta = network->forward(inputBatch(held_out, sample).to(network->parameters().front().device())).cpu();
    if (std::get<1>(leastLosses(network, representation, held_out, sample, options.loss)).item<int64_t>() > 0)
      theta = solveLastLayers(theta, SampleTargets(representation, held_out, sample, options.loss));
    worst[i].function = static_cast<uint32_t>(sample.front().function);
    worst[i].blend_rmse = std::sqrt(losses[i].first);
    takePlane(held_out.function(sample.front().function), valuesOf(network, representation, theta[0]), &worst[i]);
  }
  return worst;
}

nlohmann::ordered_json worstFunctionsJson(int64_t step, const std::vector<WorstFunction>& worst) {
  nlohmann::ordered_json functions = nlohmann::ordered_json::array();
  for (const WorstFunction& one : worst) {
    nlohmann::ordered_json points = nlohmann::ordered_json::array();
    for (const WorstFunction::Point& point : one.points)
      points.push_back({rounded(point.u), rounded(point.v), rounded(point.target), rounded(point.predicted)});
    functions.push_back(
        {{"function", one.function}, {"blend_rmse", one.blend_rmse}, {"axis", one.axis}, {"points", std::move(points)}});
  }
  return {{"step", step}, {"functions", std::move(functions)}};
}

}  // namespace nlg
