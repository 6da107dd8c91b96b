#include "validate/light/neural/dense_training.h"

#include <gtest/gtest.h>
#include <torch/utils.h>

#include <cmath>

#include "tests/validate/light/neural/learned_places.h"
#include "tool/error.h"
#include "validate/light/neural/learned_methods.h"
#include "validate/light/neural/siren.h"
#include "validate/light/neural/voxel_networks.h"

namespace nlg {
namespace {

TEST(DenseTraining, GradientIsThatOfFiniteDifferences) {
  for (const Activation activation : {Activation::relu, Activation::sine}) {
    const DenseShape shape{{6, 9, 8, 3}, activation, 3.0f};
    const torch::Tensor parameters = initialParameters(shape, 5).detach().to(torch::kDouble).requires_grad_();
    torch::Tensor input = torch::empty({7, 6}, torch::kDouble);
    Random random(2);
    for (int i = 0; i < 42; ++i) input.data_ptr<double>()[i] = random.uniform(-1.0, 1.0);
    const auto value = [&](const torch::Tensor& at) { return evaluateBatch(shape, at, input).square().sum(); };
    value(parameters).backward();
    const torch::NoGradGuard no_gradients;
    for (int64_t i = 0; i < parameters.numel(); i += 3) {
      torch::Tensor high = parameters.detach().clone(), low = parameters.detach().clone();
      constexpr double kStep = 1e-6;
      high.data_ptr<double>()[i] += kStep;
      low.data_ptr<double>()[i] -= kStep;
      const double slope = parameters.grad().data_ptr<double>()[i];
      // doubles: 1e-16 of a sum of about 10 over the step
      EXPECT_NEAR(slope, (value(high) - value(low)).item<double>() / (2.0 * kStep), 1e-6 * (1.0 + std::fabs(slope)))
          << "number " << i;
    }
  }
}

TrainingOptions shortTraining(int steps, float rate) {
  TrainingOptions options;
  options.steps = steps;
  options.check_steps = 50;
  options.rate = rate;
  return options;
}

TEST(VoxelNetworks, GiveEachVoxelItsOwnLight) {
  // 8 x 3 x 5 m are 2 x 1 x 2 voxels; light changes where they meet
  const auto light = [](const glm::dvec3& p) { return ambient(glm::vec3(p.x < 24.0 ? 1.0f : 0.2f, 1.0f, 0.5f)); };
  const LitPlaces lit = placesWithLight(4000, light);
  VoxelNetworksOptions options;
  options.width = 16;
  options.training = shortTraining(400, 3e-3f);
  const LearnedLight learned = trainVoxelNetworks(lit, splitPlaces(4000, 1), options);
  EXPECT_EQ(learned.cost.networks, 4u);
  const size_t numbers = 7 * 16 + 17 * 16 + 17 * 3;
  EXPECT_EQ(learned.bytes.light, 4 * 2 * numbers);
  EXPECT_EQ(learned.cost.words_by_place, (numbers + 1) / 2);
  // some centimetres from the face between them, which is at the lowest place's x + 4
  for (const double x : {23.9, 24.1}) {
    const LightAnswer answer = answerAt(learned.light_at, {{x, 0.5, 5.0}, {0.0f, 1.0f, 0.0f}});
    EXPECT_EQ(answer.reach, Reach::lit);
    const float expected = 3.14159265f * (x < 24.0 ? 1.0f : 0.2f);
    EXPECT_NEAR(answer.irradiance.r, expected, 0.1f * expected);
  }
}

TEST(Siren, LearnsLightThatChangesOverTheScene) {
  const auto light = [](const glm::dvec3& p) {
    return ambient(glm::vec3(static_cast<float>(1.0 + 0.5 * std::sin(1.5 * p.x) * std::cos(p.z))));
  };
  const LitPlaces lit = placesWithLight(4000, light);
  SirenOptions options;
  options.width = 32;
  options.hidden_layers = 3;
  options.batch = 512;
  options.training = shortTraining(2000, 2e-3f);
  const LearnedLight learned = trainSiren(lit, splitPlaces(4000, 1), options);
  EXPECT_EQ(learned.bytes.total(), 2u * (7 * 32 + 2 * 33 * 32 + 33 * 3));
  double squares = 0.0;
  for (int i = 0; i < 500; ++i) {
    const double expected = 3.14159265 * light(lit.position_m[i])[0].g / 3.5449077;
    squares +=
        std::pow(answerAt(learned.light_at, {lit.position_m[i], {0.0f, 1.0f, 0.0f}}).irradiance.g / expected - 1.0, 2) / 500.0;
  }
  // the mean alone is .25 off
  EXPECT_LT(std::sqrt(squares), 0.05);
}

}  // namespace
}  // namespace nlg
