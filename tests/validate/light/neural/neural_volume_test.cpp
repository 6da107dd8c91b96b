#include "validate/light/neural/neural_volume.h"

#include <gtest/gtest.h>

#include "tests/validate/light/neural/learned_places.h"
#include "validate/light/neural/dense_training.h"
#include "validate/light/neural/lit_places.h"

namespace nlg {
namespace {

NeuralVolumeOptions smallVolume(int steps) {
  NeuralVolumeOptions options;
  options.table_log2 = 8;
  options.width = 16;
  options.batch = 256;
  options.training.steps = steps;
  options.training.check_steps = 50;
  return options;
}

TEST(DenseNetwork, GivesWhatTheTrainedOneGives) {
  const DenseShape shape{{6, 20, 33, 3}};
  const torch::Tensor parameters = initialParameters(shape, 3);
  ASSERT_EQ(static_cast<size_t>(parameters.numel()), 7u * 20 + 21 * 33 + 34 * 3);
  const DenseNetwork network(shape, floatsOf(parameters));
  torch::Tensor input = torch::empty({10, 6});
  Random random(1);
  for (int i = 0; i < 60; ++i) input.data_ptr<float>()[i] = static_cast<float>(random.uniform(-1.0, 1.0));
  const torch::Tensor expected = evaluateBatch(shape, parameters, input).detach();
  for (int i = 0; i < 10; ++i) {
    float output[3];
    network.evaluate(input.data_ptr<float>() + 6 * i, output);
    // sums of 33 in another order
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(output[c], expected[i][c].item<float>(), 5e-5f) << "place " << i;
  }
}

TEST(LightSamples, TargetsAreIrradianceInUnitsForTheNormalThatStandsBesideThem) {
  LightSh light = ambient({1.0f, 2.0f, 3.0f});
  light[3] = glm::vec3(0.5f, 0.0f, 0.1f);  // more from +x
  const LitPlaces lit = placesWithLight(100, [&](const glm::dvec3&) { return light; });
  const PlaceSplit split = splitPlaces(100, 1);
  const LightSamples samples(lit, split.learned, split.held_out, frameAround(lit.position_m), 2.0f, 1);
  Random random(1);
  for (const SampleBatch& batch : {samples.draw(50, &random), samples.heldOut()}) {
    for (int64_t i = 0; i < batch.input.size(0); ++i) {
      const float* input = batch.input.data_ptr<float>() + kSampleInputs * i;
      const glm::vec3 expected = irradiance(light, {input[3], input[4], input[5]}) / 2.0f;
      for (int c = 0; c < 3; ++c) EXPECT_FLOAT_EQ(batch.target[i][c].item<float>(), expected[c]);
      for (int axis = 0; axis < 3; ++axis) EXPECT_LE(std::fabs(input[axis]), 1.0f);
    }
  }
}

TEST(NeuralVolume, LearnsConstantLightToFloat16) {
  const LitPlaces lit = placesWithLight(2000, [](const glm::dvec3&) { return ambient({1.0f, 2.0f, 0.5f}); });
  const LearnedLight learned = trainNeuralVolume(lit, splitPlaces(2000, 1), smallVolume(2500));
  for (int i = 0; i < 100; ++i) {
    const LightAnswer answer =
        answerAt(learned.light_at, {lit.position_m[i], glm::normalize(glm::vec3(i % 7 - 3, i % 5 - 2, 1.0f))});
    for (int c = 0; c < 3; ++c) {
      const float expected = 3.14159265f * glm::vec3(1.0f, 2.0f, 0.5f)[c];
      EXPECT_NEAR(answer.irradiance[c], expected, 0.01f * expected) << "place " << i;
    }
  }
}

TEST(NeuralVolume, LearnsAWallThatNoCellOfItsCoarsestLevelHolds) {
  // light on one side alone, 20 m and more from the origin
  const auto light = [](const glm::dvec3& p) { return ambient(glm::vec3(p.x < 24.1 ? 1.0f : 0.05f)); };
  const LitPlaces lit = placesWithLight(8000, light);
  NeuralVolumeOptions options = smallVolume(1000);
  options.table_log2 = 12;
  const LearnedLight learned = trainNeuralVolume(lit, splitPlaces(8000, 1), options);
  const auto meanAt = [&](double x) {
    float sum = 0.0f;
    for (int i = 0; i < 16; ++i)
      sum += answerAt(learned.light_at, {{x, -0.5 + 0.125 * i, 4.0 + 0.2 * i}, {0.0f, 1.0f, 0.0f}}).irradiance.g / 16.0f;
    return sum / 3.14159265f;
  };
  // a cell of the coarsest level is half a metre: a blend across it would have .5 a quarter of a metre from the wall
  EXPECT_NEAR(meanAt(23.85), 1.0, 0.15);
  EXPECT_NEAR(meanAt(24.35), 0.05, 0.15);
}

}  // namespace
}  // namespace nlg
