#include "validate/light/neural/latent_bake.h"

#include <torch/utils.h>

#include <algorithm>
#include <memory>

#include "tool/error.h"
#include "validate/light/neural/dense_training.h"
#include "validate/light/neural/voxel_lattice.h"

namespace nlg {
namespace {

constexpr uint64_t kEncoderStream = 0x656e63, kDecoderStream = 0x646563, kHeldOutStream = 0x68656c64, kHalfStream = 0x68616c66;
constexpr int kObservation = 3 + kShFloats, kEncoderWidth = 128;
constexpr size_t kHeldOutOfVoxel = 32;  // places, at most

// One voxel, and what is known of it.
class ObservedVoxel {
 public:
  ObservedVoxel(const LitPlaces& lit, const VoxelLattice& lattice, const VoxelPlaces& of, float unit, uint64_t seed)
      : voxel_(of.voxel),
        learned_(of.split.learned),
        samples_(lit, of.split.learned, of.split.held_out, lattice.frameOf(of.voxel), unit,
                 mixSeed(seed, kHeldOutStream, of.voxel)) {
    for (const uint32_t place : learned_) {
      const glm::vec3 position = lattice.frameOf(voxel_).inFrame(lit.position_m[place]);
      observations_.insert(observations_.end(), &position.x, &position.x + 3);
      for (const glm::vec3& coefficient : lit.light[place]) {
        for (int c = 0; c < kShChannels; ++c) observations_.push_back(coefficient[c] / unit);
      }
    }
  }
  size_t voxel() const { return voxel_; }
  const LightSamples& samples() const { return samples_; }
  size_t observationCount() const { return learned_.size(); }
  const float* observation(size_t i) const { return observations_.data() + kObservation * i; }

 private:
  size_t voxel_;
  std::vector<uint32_t> learned_;
  LightSamples samples_;
  std::vector<float> observations_;
};

class LatentLearner : public Learner {
 public:
  // voxels   what is learned from
  LatentLearner(std::vector<const ObservedVoxel*> voxels, const LatentBakeOptions& options)
      : voxels_(std::move(voxels)),
        options_(options),
        encoder_{{kObservation, kEncoderWidth, kEncoderWidth, options.latent}},
        decoder_{{options.latent + static_cast<int>(kSampleInputs)}} {
    decoder_.widths.insert(decoder_.widths.end(), static_cast<size_t>(options.decoder_layers), options.decoder_width);
    decoder_.widths.push_back(kShChannels);
    parameters_ = {initialParameters(encoder_, mixSeed(options.training.seed, kEncoderStream)),
                   initialParameters(decoder_, mixSeed(options.training.seed, kDecoderStream))};
  }

  std::vector<torch::Tensor>& parameters() override { return parameters_; }
  torch::Tensor loss(Random* random) override {
    std::vector<torch::Tensor> answers, targets;
    for (int v = 0; v < options_.batch_voxels; ++v) {
      const ObservedVoxel& voxel = *voxels_[random->below(static_cast<uint32_t>(voxels_.size()))];
      const SampleBatch batch = voxel.samples().draw(options_.batch_places, random);
      answers.push_back(decoderInput(observed(voxel, random), batch.input));
      targets.push_back(batch.target);
    }
    return symmetricShares(evaluateBatch(decoder_, parameters_[1], torch::cat(answers)), torch::cat(targets));
  }
  double heldOutLoss() override {
    const torch::NoGradGuard no_gradients;
    Random random(mixSeed(options_.training.seed, kHeldOutStream));
    std::vector<torch::Tensor> inputs, targets;
    for (const ObservedVoxel* voxel : voxels_) {
      const SampleBatch& held_out = voxel->samples().heldOut();
      const int64_t count = std::min<int64_t>(held_out.input.size(0), kHeldOutOfVoxel);
      inputs.push_back(decoderInput(observed(*voxel, &random), held_out.input.narrow(0, 0, count)));
      targets.push_back(held_out.target.narrow(0, 0, count));
    }
    return symmetricShares(evaluateBatch(decoder_, parameters_[1], torch::cat(inputs)), torch::cat(targets)).item<double>();
  }
  const DenseShape& encoder() const { return encoder_; }
  const DenseShape& decoder() const { return decoder_; }

 private:
  // The latent that observations by chance give.
  torch::Tensor observed(const ObservedVoxel& voxel, Random* random) {
    torch::Tensor observations = torch::empty({options_.batch_places, kObservation});
    for (int64_t i = 0; i < options_.batch_places; ++i) {
      const size_t of = random->below(static_cast<uint32_t>(voxel.observationCount()));
      std::copy_n(voxel.observation(of), kObservation, observations.data_ptr<float>() + kObservation * i);
    }
    return evaluateBatch(encoder_, parameters_[0], observations).mean(0, true);
  }
  static torch::Tensor decoderInput(const torch::Tensor& latent, const torch::Tensor& samples) {
    return torch::cat({latent.expand({samples.size(0), -1}), samples}, 1);
  }

  const std::vector<const ObservedVoxel*> voxels_;
  const LatentBakeOptions& options_;
  DenseShape encoder_, decoder_;
  std::vector<torch::Tensor> parameters_;  // of the encoder, of the decoder
};

struct LatentLight {
  VoxelLattice lattice;
  float unit;
  std::vector<uint32_t> latent_of;  // by voxel
  struct Latent {
    size_t voxel;
    std::vector<float> numbers;
    std::shared_ptr<const DenseNetwork> decoder;
  };
  std::vector<Latent> latents;

  LightAnswer irradianceAt(const glm::dvec3& position_m, const glm::vec3& normal) const {
    const size_t voxel = lattice.at(position_m);
    const Latent& latent = latents[latent_of[voxel]];
    const glm::vec3 place = glm::clamp(lattice.frameOf(latent.voxel).inFrame(position_m), glm::vec3(-1.0f), glm::vec3(1.0f));
    float input[DenseShape::kMostWidth];
    float* at = std::copy(latent.numbers.begin(), latent.numbers.end(), input);
    std::copy_n(&normal.x, 3, std::copy_n(&place.x, 3, at));
    LightAnswer answer{glm::vec3(0.0f), latent.voxel == voxel ? Reach::lit : Reach::fallback};
    latent.decoder->evaluate(input, &answer.irradiance.x);
    answer.irradiance = unit * glm::max(answer.irradiance, glm::vec3(0.0f));
    return answer;
  }
};

// All of the voxel's observations.
std::vector<float> latentOf(const ObservedVoxel& voxel, const DenseNetwork& encoder) {
  std::vector<float> mean(static_cast<size_t>(encoder.shape().widths.back())), one(mean.size());
  for (size_t i = 0; i < voxel.observationCount(); ++i) {
    encoder.evaluate(voxel.observation(i), one.data());
    for (size_t l = 0; l < mean.size(); ++l) mean[l] += one[l] / static_cast<float>(voxel.observationCount());
  }
  return mean;
}

}  // namespace

LearnedLight trainLatentBake(const LitPlaces& lit, const PlaceSplit& split, const LatentBakeOptions& options) {
  const VoxelLattice lattice(lit.position_m, options.voxel_m);
  // light is learned over its mean: one learning rate serves all scenes
  const float unit = meanIrradiance(lit.light);
  std::vector<ObservedVoxel> voxels;
  std::vector<size_t> voxel_of;
  std::array<std::vector<const ObservedVoxel*>, 2> half;
  for (const VoxelPlaces& of : placesByVoxel(lattice, lit, split)) {
    voxels.emplace_back(lit, lattice, of, unit, options.training.seed);
    voxel_of.push_back(of.voxel);
  }
  const bool is_own = options.voxels == LatentVoxels::own;
  // every second one, in an order by chance
  std::vector<size_t> order(voxels.size());
  for (size_t v = 0; v < order.size(); ++v) order[v] = v;
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return mixSeed(options.training.seed, kHalfStream, a) < mixSeed(options.training.seed, kHalfStream, b);
  });
  for (size_t i = 0; i < order.size(); ++i) half[is_own ? 0 : i % 2].push_back(&voxels[order[i]]);
  if (!is_own && half[1].empty())
    throw InputError("the scene", "air", "two voxels with enough sample points to learn light from", "one");

  LearnedLight learned;
  LearnedCost& cost = learned.cost;
  // unless asked for their own, voxels are encoded by the network that the other half trained
  LatentLight all{lattice, unit, nearestOf(lattice, voxel_of), std::vector<LatentLight::Latent>(voxels.size())};
  for (size_t h = 0; h < (is_own ? 1u : 2u); ++h) {
    LatentLearner learner(half[h], options);
    const TrainingRecord record = train(&learner, options.training);
    const DenseNetwork encoder(learner.encoder(), floatsOf(learner.parameters()[0]));
    const auto decoder =
        std::make_shared<const DenseNetwork>(learner.decoder(), roundedToHalf(floatsOf(learner.parameters()[1]), &cost.clamped));
    for (const ObservedVoxel* voxel : half[is_own ? h : 1 - h])
      all.latents[voxel - voxels.data()] = {voxel->voxel(), roundedToHalf(latentOf(*voxel, encoder), &cost.clamped), decoder};
    cost.steps += static_cast<size_t>(record.steps);
    cost.training_s += record.processor_s;
  }
  // costs as a game would have them: numbers in half precision, fetched in words
  for (const ObservedVoxel& voxel : voxels) cost.places += voxel.observationCount();
  const DenseShape& decoder = all.latents.front().decoder->shape();
  const size_t latent_numbers = voxels.size() * static_cast<size_t>(options.latent);
  cost.networks = 1;
  cost.parameters = latent_numbers + decoder.parameterCount();
  cost.multiply_adds = decoder.multiplyAdds();
  cost.words_by_place = (static_cast<size_t>(options.latent) + kLearnedInWord - 1) / kLearnedInWord;
  cost.words_shared = (decoder.parameterCount() + kLearnedInWord - 1) / kLearnedInWord;
  // which latent a voxel has
  learned.bytes = {kLearnedBytes * latent_numbers, kLearnedBytes * decoder.parameterCount(), lattice.size() * sizeof(uint32_t)};
  const auto light = std::make_shared<const LatentLight>(std::move(all));
  learned.irradiance_at = [light](const glm::dvec3& position_m, const glm::vec3& normal) {
    return light->irradianceAt(position_m, normal);
  };
  return learned;
}

}  // namespace nlg
