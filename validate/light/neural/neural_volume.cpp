#include "validate/light/neural/neural_volume.h"

#include <torch/autograd.h>
#include <torch/utils.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "tool/error.h"
#include "validate/light/neural/dense_training.h"

namespace nlg {
namespace {

// the paper's; the first is 1
constexpr uint32_t kHashY = 2654435761u, kHashZ = 805459861u;

class HashFeatures : public torch::autograd::Function<HashFeatures> {
 public:
  static torch::Tensor forward(torch::autograd::AutogradContext* context, const torch::Tensor& table,
                               const torch::Tensor& position, int64_t grid_address) {
    context->save_for_backward({position});
    context->saved_data["grid"] = grid_address;
    context->saved_data["numbers"] = table.numel();
    const auto& grid = *reinterpret_cast<const HashGrid*>(grid_address);
    const int64_t count = position.size(0), stride = position.stride(0);
    torch::Tensor features = torch::empty({count, kHashOutputs});
    for (int64_t i = 0; i < count; ++i) {
      grid.featuresAt(position.data_ptr<float>() + i * stride, table.data_ptr<float>(),
                      features.data_ptr<float>() + i * kHashOutputs);
    }
    return features;
  }

  static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                 torch::autograd::variable_list by_features) {
    const torch::Tensor position = context->get_saved_variables()[0], slope = by_features[0].contiguous();
    const auto& grid = *reinterpret_cast<const HashGrid*>(context->saved_data["grid"].toInt());
    torch::Tensor by_table = torch::zeros({context->saved_data["numbers"].toInt()});
    float* sums = by_table.data_ptr<float>();
    HashGrid::Corners corners;
    for (int64_t i = 0; i < position.size(0); ++i) {
      grid.cornersAt(position.data_ptr<float>() + i * position.stride(0), &corners);
      const float* of_place = slope.data_ptr<float>() + i * kHashOutputs;
      for (int c = 0; c < kHashCorners; ++c) {
        const float* of_level = of_place + c / 8 * kHashFeatures;
        float* row = sums + static_cast<size_t>(corners.row[c]) * kHashFeatures;
        for (int f = 0; f < kHashFeatures; ++f) row[f] += corners.share[c] * of_level[f];
      }
    }
    return {by_table, torch::Tensor(), torch::Tensor()};
  }
};

constexpr uint64_t kTableStream = 0x7461626c65;
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

HashGrid::HashGrid(double half_m, const glm::vec3& low, const glm::vec3& high, int table_log2) : low_(low), high_(high) {
  NLG_CHECK(table_log2, >=, 4);
  NLG_CHECK(table_log2, <=, 24);
  const double cells = 2.0 * half_m / kFinestHashCellM;
  const double growth = std::clamp(std::pow(cells / kCoarsestCells, 1.0 / (kHashLevels - 1)), kLeastHashGrowth, kMostHashGrowth);
  const uint32_t most = 1u << table_log2;
  for (int l = 0; l < kHashLevels; ++l) {
    Level& level = levels_[l];
    level.scale = static_cast<float>(0.5 * kCoarsestCells * std::pow(growth, l));
    uint64_t nodes = 1;
    for (int axis = 0; axis < 3; ++axis) {
      level.nodes[axis] = static_cast<uint32_t>(std::floor((high[axis] - low[axis]) * level.scale)) + 2;
      nodes *= level.nodes[axis];
    }
    level.first_row = static_cast<uint32_t>(row_count_);
    level.mask = nodes <= most ? 0 : most - 1;
    row_count_ += std::min<uint64_t>(nodes, most);
  }
}

void HashGrid::cornersAt(const float* position_3, Corners* corners) const {
  // positions outside the box get its border
  glm::vec3 place;
  for (int axis = 0; axis < 3; ++axis) place[axis] = std::clamp(position_3[axis], low_[axis], high_[axis]) - low_[axis];
  for (int l = 0; l < kHashLevels; ++l) {
    const Level& level = levels_[l];
    std::array<uint32_t, 3> node;
    glm::vec3 above;
    // the cell and the place in it; the last node begins no cell
    for (int axis = 0; axis < 3; ++axis) {
      const float cells = place[axis] * level.scale;
      node[axis] = std::min(static_cast<uint32_t>(cells), level.nodes[axis] - 2);
      above[axis] = cells - static_cast<float>(node[axis]);
    }
    // coarse levels have a row for every node; fine ones hash nodes into a table (Müller and others 2022)
    for (uint32_t c = 0; c < 8; ++c) {
      const uint32_t dx = c & 1, dy = c >> 1 & 1, dz = c >> 2 & 1;
      const uint32_t x = node[0] + dx, y = node[1] + dy, z = node[2] + dz;
      const uint32_t at =
          level.mask != 0 ? (x ^ y * kHashY ^ z * kHashZ) & level.mask : x + level.nodes[0] * (y + level.nodes[1] * z);
      corners->row[8 * l + c] = level.first_row + at;
      corners->share[8 * l + c] =
          (dx != 0 ? above.x : 1.0f - above.x) * (dy != 0 ? above.y : 1.0f - above.y) * (dz != 0 ? above.z : 1.0f - above.z);
    }
  }
}

void HashGrid::featuresAt(const float* position_3, const float* table, float* features) const {
  Corners corners;
  cornersAt(position_3, &corners);
  std::fill_n(features, kHashOutputs, 0.0f);
  for (int c = 0; c < kHashCorners; ++c) {
    const float* row = table + static_cast<size_t>(corners.row[c]) * kHashFeatures;
    for (int f = 0; f < kHashFeatures; ++f) features[c / 8 * kHashFeatures + f] += corners.share[c] * row[f];
  }
}

torch::Tensor hashFeatures(const HashGrid& grid, const torch::Tensor& position, const torch::Tensor& table) {
  NLG_CHECK(table.numel(), ==, static_cast<int64_t>(grid.rowCount()) * kHashFeatures);
  NLG_CHECK(position.size(1), >=, 3);
  NLG_CHECK(position.stride(1), ==, 1);
  return HashFeatures::apply(table, position, reinterpret_cast<int64_t>(&grid));
}

LearnedLight trainNeuralVolume(const LitPlaces& lit, const PlaceSplit& split, const NeuralVolumeOptions& options) {
  // light over its mean, positions over the scene's size
  const SampleFrame frame = frameAround(lit.position_m);
  const float unit = meanIrradiance(lit.light);
  const HashGrid grid = gridAround(lit, frame, options.table_log2);
  const LightSamples samples(lit, split.learned, split.held_out, frame, unit, mixSeed(options.training.seed, kHeldOutStream));
  VolumeLearner learner(grid, samples, options);
  const TrainingRecord record = train(&learner, options.training);

  // what a game would store and compute: features and network in half precision
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
  learned.light_at = lightOf(volume);
  return learned;
}

}  // namespace nlg
