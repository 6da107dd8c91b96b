#include "validate/light/neural/network_grid.h"

#include <torch/utils.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "validate/light/neural/dense_training.h"

namespace nlg {
namespace {

constexpr int kBlended = 4;

// Nodes of a lattice around the places, the middles of voxels.
struct Nodes {
  glm::dvec3 low_m;  // the lowest voxel's lowest corner
  std::array<int, 3> count{};
  SampleFrame frame;                 // positions in it count nodes from the lowest
  std::vector<size_t> node_of;       // by network
  std::vector<uint32_t> network_of;  // by node: its own, or the nearest's

  struct Blend {
    std::array<size_t, kBlended> node;
    std::array<float, kBlended> share;  // sum to 1
  };

  Nodes(const LitPlaces& lit, const std::vector<uint32_t>& learned, double spacing_m) : low_m(lit.position_m.front()) {
    glm::dvec3 high_m = low_m;
    for (const glm::dvec3& place : lit.position_m) {
      low_m = glm::min(low_m, place);
      high_m = glm::max(high_m, place);
    }
    for (int axis = 0; axis < 3; ++axis) count[axis] = 2 + static_cast<int>((high_m[axis] - low_m[axis]) / spacing_m);
    low_m -= 0.5 * spacing_m;
    frame = {low_m + 0.5 * spacing_m, spacing_m};
    std::vector<bool> is_read(static_cast<size_t>(count[0]) * count[1] * count[2]);
    for (const uint32_t place : learned) {
      for (const size_t node : blendAt(frame.inFrame(lit.position_m[place])).node) is_read[node] = true;
    }
    for (size_t node = 0; node < is_read.size(); ++node) {
      if (is_read[node]) node_of.push_back(node);
    }
    for (size_t node = 0; node < is_read.size(); ++node) {
      const auto distance = [&](size_t other) {
        const glm::dvec3 way = positionOf(other) - positionOf(node);
        return glm::dot(way, way);
      };
      const auto nearest =
          std::min_element(node_of.begin(), node_of.end(), [&](size_t a, size_t b) { return distance(a) < distance(b); });
      network_of.push_back(static_cast<uint32_t>(nearest - node_of.begin()));
    }
  }

  glm::dvec3 positionOf(size_t node) const {
    const size_t x = node % count[0], y = node / count[0] % count[1], z = node / count[0] / count[1];
    return low_m + frame.half_m * (glm::dvec3(x, y, z) + 0.5);
  }

  Blend blendAt(const glm::vec3& position) const {
    size_t node = 0, stride = 1;
    std::array<std::pair<float, size_t>, 3> ways;  // how far towards the next node, and the way there
    for (int axis = 0; axis < 3; ++axis) {
      const float cell = std::clamp(std::floor(position[axis]), 0.0f, static_cast<float>(count[axis] - 2));
      ways[axis] = {std::clamp(position[axis] - cell, 0.0f, 1.0f), stride};
      node += static_cast<size_t>(cell) * stride;
      stride *= static_cast<size_t>(count[axis]);
    }
    // barycentric in one of the six tetrahedra of a cube, which the order of coordinates chooses: four networks, not eight
    std::sort(ways.rbegin(), ways.rend());
    Blend blend;
    float before = 1.0f;
    for (int c = 0; c < kBlended; ++c) {
      const auto [next, way] = c < 3 ? ways[c] : std::pair<float, size_t>();
      blend.node[c] = node;
      blend.share[c] = before - next;
      before = next;
      node += way;
    }
    return blend;
  }

  // As a network reads it.
  glm::vec3 aroundNode(uint32_t network, const glm::vec3& position) const {
    const glm::vec3 node = frame.inFrame(positionOf(node_of[network]));
    return glm::clamp(position - node, glm::vec3(-1.0f), glm::vec3(1.0f));
  }
};

class NetworkGridLearner : public Learner {
 public:
  NetworkGridLearner(const Nodes& nodes, const LightSamples& samples, const NetworkGridOptions& options)
      : nodes_(nodes),
        samples_(samples),
        shape_{{static_cast<int>(kSampleInputs), options.width, options.width, kShChannels}},
        batch_(options.batch) {
    std::vector<torch::Tensor> networks;
    for (size_t n = 0; n < nodes.node_of.size(); ++n)
      networks.push_back(initialParameters(shape_, mixSeed(options.training.seed, kNetworkStream, n)).detach());
    parameters_ = {torch::stack(networks).requires_grad_()};
  }

  std::vector<torch::Tensor>& parameters() override { return parameters_; }
  torch::Tensor loss(Random* random) override {
    const SampleBatch batch = samples_.draw(batch_, random);
    return symmetricShares(answersTo(batch), batch.target);
  }
  double heldOutLoss() override {
    const torch::NoGradGuard no_gradients;
    return symmetricShares(answersTo(samples_.heldOut()), samples_.heldOut().target).item<double>();
  }
  const DenseShape& shape() const { return shape_; }

 private:
  // Every network has a batch of its own, as long as the longest.
  torch::Tensor answersTo(const SampleBatch& batch) {
    const int64_t count = batch.input.size(0), networks = parameters_[0].size(0);
    torch::Tensor share = torch::empty({count, kBlended, 1}), row = torch::empty({count * kBlended}, torch::kLong);
    std::vector<uint32_t> network_of(static_cast<size_t>(count) * kBlended);
    std::vector<int64_t> filled(static_cast<size_t>(networks), 0);
    const float* sample = batch.input.data_ptr<float>();
    const auto positionOf = [&](int64_t i) {
      return glm::vec3(sample[kSampleInputs * i], sample[kSampleInputs * i + 1], sample[kSampleInputs * i + 2]);
    };
    for (int64_t i = 0; i < count; ++i) {
      const Nodes::Blend blend = nodes_.blendAt(positionOf(i));
      for (int64_t c = 0, at = kBlended * i; c < kBlended; ++c, ++at) {
        network_of[at] = nodes_.network_of[blend.node[c]];
        row.data_ptr<int64_t>()[at] = filled[network_of[at]]++;
        share.data_ptr<float>()[at] = blend.share[c];
      }
    }
    const int64_t most = *std::max_element(filled.begin(), filled.end());
    torch::Tensor input = torch::zeros({networks, most, kSampleInputs});
    for (int64_t at = 0; at < count * kBlended; ++at) {
      const glm::vec3 around = nodes_.aroundNode(network_of[at], positionOf(at / kBlended));
      int64_t& of = row.data_ptr<int64_t>()[at];
      of += most * network_of[at];
      float* to = std::copy_n(&around.x, 3, input.data_ptr<float>() + kSampleInputs * of);
      std::copy_n(sample + kSampleInputs * (at / kBlended) + 3, 3, to);
    }
    const torch::Tensor answers = evaluateBatch(shape_, parameters_[0], input).view({-1, kShChannels});
    return (answers.index_select(0, row).view({count, kBlended, kShChannels}) * share).sum(1);
  }

  const Nodes& nodes_;
  const LightSamples& samples_;
  const DenseShape shape_;
  const int64_t batch_;
  std::vector<torch::Tensor> parameters_;  // a network after another
};

struct NetworkGrid {
  Nodes nodes;
  float unit;
  std::vector<DenseNetwork> networks;

  LightAnswer irradianceAt(const glm::dvec3& position_m, const glm::vec3& normal) const {
    const glm::vec3 position = nodes.frame.inFrame(position_m);
    const Nodes::Blend blend = nodes.blendAt(position);
    LightAnswer answer{glm::vec3(0.0f), Reach::lit};
    for (int c = 0; c < kBlended; ++c) {
      const uint32_t network = nodes.network_of[blend.node[c]];
      if (nodes.node_of[network] != blend.node[c] && blend.share[c] > 0.0f) answer.reach = Reach::fallback;
      const glm::vec3 around = nodes.aroundNode(network, position);
      const float input[kSampleInputs] = {around.x, around.y, around.z, normal.x, normal.y, normal.z};
      glm::vec3 of_node;
      networks[network].evaluate(input, &of_node.x);
      answer.irradiance += blend.share[c] * of_node;
    }
    answer.irradiance = unit * glm::max(answer.irradiance, glm::vec3(0.0f));
    return answer;
  }
};

}  // namespace

LearnedLight trainNetworkGrid(const LitPlaces& lit, const PlaceSplit& split, const NetworkGridOptions& options) {
  // a network for each node that some learned place reads: none where there is no air
  Nodes nodes(lit, split.learned, options.spacing_m);
  const float unit = meanIrradiance(lit.light);
  const LightSamples samples(lit, split.learned, split.held_out, nodes.frame, unit,
                             mixSeed(options.training.seed, kHeldOutStream));
  NetworkGridLearner learner(nodes, samples, options);
  const TrainingRecord record = train(&learner, options.training);

  // what a game would store and compute: the blend evaluates every node around a position
  LearnedLight learned;
  LearnedCost& cost = learned.cost;
  const DenseShape& shape = learner.shape();
  const std::vector<float> numbers = roundedToHalf(floatsOf(learner.parameters()[0]), &cost.clamped);
  cost.networks = nodes.node_of.size();
  cost.parameters = numbers.size();
  cost.multiply_adds = kBlended * (shape.multiplyAdds() + kShChannels);
  cost.words_by_place = kBlended * ((shape.parameterCount() + kLearnedInWord - 1) / kLearnedInWord);
  cost.places = split.learned.size();
  cost.steps = static_cast<size_t>(record.steps);
  cost.training_s = record.processor_s;
  // which network a node has
  learned.bytes = {kLearnedBytes * cost.parameters, 0, nodes.network_of.size() * sizeof(uint32_t)};
  // networks from the one list of numbers that was trained
  std::vector<DenseNetwork> networks;
  for (auto first = numbers.begin(); first != numbers.end(); first += static_cast<ptrdiff_t>(shape.parameterCount()))
    networks.emplace_back(shape, std::vector<float>(first, first + static_cast<ptrdiff_t>(shape.parameterCount())));
  const auto grid = std::make_shared<const NetworkGrid>(NetworkGrid{std::move(nodes), unit, std::move(networks)});
  learned.light_at = lightOf(grid);
  return learned;
}

}  // namespace nlg
