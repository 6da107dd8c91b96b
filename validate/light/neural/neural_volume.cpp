#include "validate/light/neural/neural_volume.h"

#include <torch/utils.h>

#include <algorithm>
#include <memory>

#include "validate/light/neural/dense_training.h"
#include "validate/light/neural/hash_grid.h"
#include "validate/light/neural/lit_places.h"

namespace nlg {
namespace {

constexpr uint64_t kTableStream = 0x7461626c65, kNetworkStream = 0x6e6574, kHeldOutStream = 0x68656c64;
constexpr double kFirstFeature = 1e-4;  // features begin uniform within it, as the paper of hash grids has them

DenseShape networkShape(int width) { return {{kHashOutputs + 3, width, width, kShChannels}}; }

HashGrid gridAround(const LitPlaces& lit, const SampleFrame& frame, int table_log2) {
  glm::vec3 low(1.0f), high(-1.0f);
  for (const glm::dvec3& position : lit.position_m) {
    low = glm::min(low, frame.inFrame(position));
    high = glm::max(high, frame.inFrame(position));
  }
  return {frame.half_m, low, high, table_log2};
}

class VolumeLearner : public Learner {
 public:
  VolumeLearner(const HashGrid& grid, const LightSamples& samples, const NeuralVolumeOptions& options)
      : grid_(grid), samples_(samples), shape_(networkShape(options.width)), batch_(options.batch) {
    torch::Tensor table = torch::empty({static_cast<int64_t>(grid.rowCount()) * kHashFeatures});
    Random random(mixSeed(options.training.seed, kTableStream));
    for (int64_t i = 0; i < table.numel(); ++i)
      table.data_ptr<float>()[i] = static_cast<float>(random.uniform(-kFirstFeature, kFirstFeature));
    parameters_ = {table.requires_grad_(), initialParameters(shape_, mixSeed(options.training.seed, kNetworkStream))};
  }

  std::vector<torch::Tensor>& parameters() override { return parameters_; }
  torch::Tensor loss(Random* random) override {
    const SampleBatch batch = samples_.draw(batch_, random);
    return relativeSquares(answersTo(batch), batch.target);
  }
  double heldOutLoss() override {
    const torch::NoGradGuard no_gradients;
    return evenSquares(answersTo(samples_.heldOut()), samples_.heldOut().target);
  }
  const DenseShape& shape() const { return shape_; }

 private:
  torch::Tensor answersTo(const SampleBatch& batch) {
    const torch::Tensor features = hashFeatures(grid_, batch.input, parameters_[0]);
    const torch::Tensor input = torch::cat({features, batch.input.narrow(1, 3, 3)}, 1);
    return evaluateBatch(shape_, parameters_[1], input);
  }

  const HashGrid& grid_;
  const LightSamples& samples_;
  const DenseShape shape_;
  const int64_t batch_;
  std::vector<torch::Tensor> parameters_;  // the table, the network
};

struct Volume {
  SampleFrame frame;
  float unit;
  HashGrid grid;
  std::vector<float> table;
  DenseNetwork network;

  LightAnswer irradianceAt(const glm::dvec3& position_m, const glm::vec3& normal) const {
    const glm::vec3 place = frame.inFrame(position_m);
    float input[kHashOutputs + 3];
    grid.featuresAt(&place.x, table.data(), input);
    std::copy_n(&normal.x, 3, input + kHashOutputs);
    glm::vec3 answer;
    network.evaluate(input, &answer.x);
    return {unit * glm::max(answer, glm::vec3(0.0f)), Reach::lit};
  }
};

}  // namespace

LearnedLight trainNeuralVolume(const LitPlaces& lit, const PlaceSplit& split, const NeuralVolumeOptions& options) {
  const SampleFrame frame = frameAround(lit.position_m);
  const float unit = meanIrradiance(lit.light);
  const HashGrid grid = gridAround(lit, frame, options.table_log2);
  const LightSamples samples(lit, split.learned, split.held_out, frame, unit, mixSeed(options.training.seed, kHeldOutStream));
  VolumeLearner learner(grid, samples, options);
  const TrainingRecord record = train(&learner, options.training);

  LearnedLight learned;
  LearnedCost& cost = learned.cost;
  std::vector<float> table = roundedToHalf(floatsOf(learner.parameters()[0]), &cost.clamped);
  DenseNetwork network(learner.shape(), roundedToHalf(floatsOf(learner.parameters()[1]), &cost.clamped));
  learned.bytes = {kLearnedBytes * table.size(), kLearnedBytes * network.parameters().size(), 0};
  cost.parameters = table.size() + network.parameters().size();
  cost.multiply_adds = network.shape().multiplyAdds() + static_cast<size_t>(kHashCorners) * kHashFeatures;
  cost.words_by_place = static_cast<size_t>(kHashCorners) * kHashFeatures / kLearnedInWord;
  cost.words_shared = (network.parameters().size() + kLearnedInWord - 1) / kLearnedInWord;
  cost.networks = 1;
  cost.places = split.learned.size();
  cost.steps = static_cast<size_t>(record.steps);
  cost.training_s = record.processor_s;
  const auto volume = std::make_shared<const Volume>(Volume{frame, unit, grid, std::move(table), std::move(network)});
  learned.irradiance_at = [volume](const glm::dvec3& position_m, const glm::vec3& normal) {
    return volume->irradianceAt(position_m, normal);
  };
  return learned;
}

}  // namespace nlg
