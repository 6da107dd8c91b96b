#include "validate/light/neural/siren.h"

#include <memory>

#include "validate/light/neural/dense_training.h"

namespace nlg {
namespace {

struct Siren {
  SampleFrame frame;
  float unit;
  DenseNetwork network;

  LightAnswer irradianceAt(const glm::dvec3& position_m, const glm::vec3& normal) const {
    const glm::vec3 place = frame.inFrame(position_m);
    const float input[kSampleInputs] = {place.x, place.y, place.z, normal.x, normal.y, normal.z};
    LightAnswer answer{glm::vec3(0.0f), Reach::lit};
    network.evaluate(input, &answer.irradiance.x);
    for (int c = 0; c < kShChannels; ++c) answer.irradiance[c] = unit * decoded(DenseCode::logarithm, answer.irradiance[c]);
    return answer;
  }
};

}  // namespace

LearnedLight trainSiren(const LitPlaces& lit, const PlaceSplit& split, const SirenOptions& options) {
  // light over its mean, positions over the scene's size
  const SampleFrame frame = frameAround(lit.position_m);
  const float unit = meanIrradiance(lit.light);
  const LightSamples samples(lit, split.learned, split.held_out, frame, unit, mixSeed(options.training.seed, 2));
  // sine activations with a higher first frequency (Sitzmann and others 2020)
  DenseShape shape{{static_cast<int>(kSampleInputs)}, Activation::sine, options.first_frequency};
  shape.widths.insert(shape.widths.end(), static_cast<size_t>(options.hidden_layers), options.width);
  shape.widths.push_back(kShChannels);
  TrainingRecord record;
  std::vector<float> numbers = trainDense(samples, shape, DenseCode::logarithm, options.batch, options.training, &record);

  // what a game would store and compute
  LearnedLight learned;
  LearnedCost& cost = learned.cost;
  const auto siren =
      std::make_shared<const Siren>(Siren{frame, unit, DenseNetwork(shape, roundedToHalf(std::move(numbers), &cost.clamped))});
  cost.parameters = shape.parameterCount();
  cost.multiply_adds = shape.multiplyAdds();
  cost.words_shared = (cost.parameters + kLearnedInWord - 1) / kLearnedInWord;
  cost.networks = 1;
  cost.places = split.learned.size();
  cost.steps = static_cast<size_t>(record.steps);
  cost.training_s = record.processor_s;
  learned.bytes.light = kLearnedBytes * cost.parameters;
  learned.light_at = lightOf(siren);
  return learned;
}

}  // namespace nlg
