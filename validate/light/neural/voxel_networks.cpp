#include "validate/light/neural/voxel_networks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "tool/error.h"
#include "tool/parallel_for.h"
#include "validate/light/neural/dense_light.h"

namespace nlg {
namespace {

// A regular lattice of voxels around all places.
struct VoxelLattice {
  glm::dvec3 low_m{0.0};
  double voxel_m = 4.0;
  std::array<int, 3> count{};

  VoxelLattice(const std::vector<glm::dvec3>& places, double side_m) : voxel_m(side_m) {
    glm::dvec3 high = places.front();
    low_m = high;
    for (const glm::dvec3& place : places) {
      low_m = glm::min(low_m, place);
      high = glm::max(high, place);
    }
    for (int axis = 0; axis < 3; ++axis) count[axis] = 1 + static_cast<int>((high[axis] - low_m[axis]) / voxel_m);
  }
  size_t size() const { return static_cast<size_t>(count[0]) * count[1] * count[2]; }
  size_t at(const glm::dvec3& position_m) const {
    std::array<size_t, 3> i;
    for (int axis = 0; axis < 3; ++axis)
      i[axis] = static_cast<size_t>(std::clamp(std::floor((position_m[axis] - low_m[axis]) / voxel_m), 0.0, count[axis] - 1.0));
    return i[0] + count[0] * (i[1] + count[1] * i[2]);
  }
  glm::dvec3 middleOf(size_t voxel) const {
    const size_t x = voxel % count[0], y = voxel / count[0] % count[1], z = voxel / count[0] / count[1];
    return low_m + voxel_m * (glm::dvec3(x, y, z) + 0.5);
  }
  SampleFrame frameOf(size_t voxel) const { return {middleOf(voxel), 0.5 * voxel_m}; }
};

struct VoxelNetworks {
  VoxelLattice lattice;
  float unit;
  std::vector<uint32_t> network_of;  // by voxel
  std::vector<size_t> voxel_of;      // by network
  std::vector<DenseNetwork> networks;

  LightAnswer irradianceAt(const glm::dvec3& position_m, const glm::vec3& normal) const {
    const size_t voxel = lattice.at(position_m);
    const uint32_t network = network_of[voxel];
    const glm::vec3 place = glm::clamp(lattice.frameOf(voxel_of[network]).inFrame(position_m), glm::vec3(-1.0f), glm::vec3(1.0f));
    const float input[kSampleInputs] = {place.x, place.y, place.z, normal.x, normal.y, normal.z};
    LightAnswer answer{glm::vec3(0.0f), voxel_of[network] == voxel ? Reach::lit : Reach::fallback};
    networks[network].evaluate(input, &answer.irradiance.x);
    for (int c = 0; c < kShChannels; ++c) answer.irradiance[c] = unit * decoded(DenseCode::plain, answer.irradiance[c]);
    return answer;
  }
};

std::vector<uint32_t> nearestNetworks(const VoxelLattice& lattice, const std::vector<size_t>& voxel_of) {
  std::vector<uint32_t> nearest(lattice.size(), 0);
  for (size_t voxel = 0; voxel < nearest.size(); ++voxel) {
    const auto distance = [&](size_t other) {
      const glm::dvec3 way = lattice.middleOf(other) - lattice.middleOf(voxel);
      return glm::dot(way, way);
    };
    const auto found =
        std::min_element(voxel_of.begin(), voxel_of.end(), [&](size_t a, size_t b) { return distance(a) < distance(b); });
    nearest[voxel] = static_cast<uint32_t>(found - voxel_of.begin());
  }
  return nearest;
}

}  // namespace

LearnedLight trainVoxelNetworks(const LitPlaces& lit, const PlaceSplit& split, const VoxelNetworksOptions& options) {
  const VoxelLattice lattice(lit.position_m, options.voxel_m);
  std::vector<PlaceSplit> of_voxel(lattice.size());
  for (const uint32_t place : split.learned) of_voxel[lattice.at(lit.position_m[place])].learned.push_back(place);
  for (const uint32_t place : split.held_out) of_voxel[lattice.at(lit.position_m[place])].held_out.push_back(place);
  std::vector<size_t> voxel_of;
  for (size_t voxel = 0; voxel < of_voxel.size(); ++voxel) {
    if (of_voxel[voxel].learned.size() >= kFewestVoxelPlaces) voxel_of.push_back(voxel);
  }
  if (voxel_of.empty()) throw InputError("the scene", "air", "a voxel with places enough to learn light from", "none");

  const float unit = meanIrradiance(lit.light);
  const DenseShape shape{{static_cast<int>(kSampleInputs), options.width, options.width, kShChannels}};
  std::vector<TrainingRecord> records(voxel_of.size());
  std::vector<std::vector<float>> numbers(voxel_of.size());
  parallelFor(voxel_of.size(), options.thread_count, [&](uint64_t n, int) {
    const size_t voxel = voxel_of[n];
    TrainingOptions training = options.training;
    training.seed = mixSeed(options.training.seed, voxel);
    const LightSamples samples(lit, of_voxel[voxel].learned, of_voxel[voxel].held_out, lattice.frameOf(voxel), unit,
                               mixSeed(training.seed, 2));
    numbers[n] = trainDense(samples, shape, DenseCode::plain, options.batch, training, &records[n]);
  });

  LearnedLight learned;
  LearnedCost& cost = learned.cost;
  VoxelNetworks all{lattice, unit, nearestNetworks(lattice, voxel_of), voxel_of, {}};
  for (std::vector<float>& of_network : numbers)
    all.networks.emplace_back(shape, roundedToHalf(std::move(of_network), &cost.clamped));
  for (const TrainingRecord& record : records) {
    cost.steps += static_cast<size_t>(record.steps);
    cost.training_s += record.processor_s;
  }
  for (const size_t voxel : voxel_of) cost.places += of_voxel[voxel].learned.size();
  cost.networks = voxel_of.size();
  cost.parameters = cost.networks * shape.parameterCount();
  cost.multiply_adds = shape.multiplyAdds();
  cost.words_by_place = (shape.parameterCount() + kLearnedInWord - 1) / kLearnedInWord;
  // which network a voxel has
  learned.bytes = {kLearnedBytes * cost.parameters, 0, lattice.size() * sizeof(uint32_t)};
  const auto networks = std::make_shared<const VoxelNetworks>(std::move(all));
  learned.irradiance_at = [networks](const glm::dvec3& position_m, const glm::vec3& normal) {
    return networks->irradianceAt(position_m, normal);
  };
  return learned;
}

}  // namespace nlg
