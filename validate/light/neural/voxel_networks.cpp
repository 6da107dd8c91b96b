#include "validate/light/neural/voxel_networks.h"

#include <memory>

#include "tool/parallel_for.h"
#include "validate/light/neural/dense_training.h"
#include "validate/light/neural/voxel_lattice.h"

namespace nlg {
namespace {

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

}  // namespace

LearnedLight trainVoxelNetworks(const LitPlaces& lit, const PlaceSplit& split, const VoxelNetworksOptions& options) {
  const VoxelLattice lattice(lit.position_m, options.voxel_m);
  // voxels with too few places have none; the nearest one answers for them
  const std::vector<VoxelPlaces> voxels = placesByVoxel(lattice, lit, split);
  const float unit = meanIrradiance(lit.light);
  const DenseShape shape{{static_cast<int>(kSampleInputs), options.width, options.width, kShChannels}};
  std::vector<TrainingRecord> records(voxels.size());
  std::vector<std::vector<float>> numbers(voxels.size());
  // seeds by voxel: threads change nothing
  parallelFor(voxels.size(), options.thread_count, [&](uint64_t n, int) {
    const auto& [voxel, places] = voxels[n];
    TrainingOptions training = options.training;
    training.seed = mixSeed(options.training.seed, voxel);
    const LightSamples samples(lit, places.learned, places.held_out, lattice.frameOf(voxel), unit, mixSeed(training.seed, 2));
    numbers[n] = trainDense(samples, shape, DenseCode::plain, options.batch, training, &records[n]);
  });

  // what a game would store and compute: one network a position
  LearnedLight learned;
  LearnedCost& cost = learned.cost;
  std::vector<size_t> voxel_of;
  for (const VoxelPlaces& of : voxels) {
    voxel_of.push_back(of.voxel);
    cost.places += of.split.learned.size();
  }
  VoxelNetworks all{lattice, unit, nearestOf(lattice, voxel_of), voxel_of, {}};
  for (std::vector<float>& of_network : numbers)
    all.networks.emplace_back(shape, roundedToHalf(std::move(of_network), &cost.clamped));
  for (const TrainingRecord& record : records) {
    cost.steps += static_cast<size_t>(record.steps);
    cost.training_s += record.processor_s;
  }
  cost.networks = voxel_of.size();
  cost.parameters = cost.networks * shape.parameterCount();
  cost.multiply_adds = shape.multiplyAdds();
  cost.words_by_place = (shape.parameterCount() + kLearnedInWord - 1) / kLearnedInWord;
  // which network a voxel has
  learned.bytes = {kLearnedBytes * cost.parameters, 0, lattice.size() * sizeof(uint32_t)};
  const auto networks = std::make_shared<const VoxelNetworks>(std::move(all));
  learned.light_at = lightOf(networks);
  return learned;
}

}  // namespace nlg
