#include "train/generator/network/theta_stages.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

#include "tests/runtime_eval/sample_generator.h"
#include "tests/train/code_network.h"
#include "train/generator/run/trainer.h"

namespace nlg {
namespace {

const TrainingData& dictionaryData() {
  static const TrainingData training(sampleSet(6, 1), codeBasis(), codeBasis());
  return training;
}

// Mirrored in places.
std::vector<Sample> samples() { return {{0, 0}, {1, 3}, {2, 7}, {5, 0}}; }

torch::Tensor someCodes(int count, uint64_t seed) {
  torch::manual_seed(seed);
  return 4.0 * torch::randn({count, kCodeCount});
}

// The slope in the direction of the gradient: what autograd says, and what a central difference does.
TEST(CodeMeanSquares, HaveTheGradientOfFiniteDifferences) {
  GeneratorNetwork network = codeNetwork(5, 3);
  torch::Tensor z = someCodes(4, 4).requires_grad_();
  const auto errorAt = [&] {
    return codeMeanSquares(network, z, dictionaryData(), samples(), -1, {.loss = {64.0, 1.0}}).to(torch::kDouble).sum();
  };
  network->zero_grad();
  errorAt().backward();
  const torch::Tensor by_z = z.grad().clone(), by_nodes = network->dictionary().grad().clone();
  const torch::NoGradGuard guard;
  for (const auto& [numbers, gradient] : {std::pair{z, by_z}, {network->dictionary(), by_nodes}}) {
    const double square = gradient.square().sum().item<double>(), step = 1e-2 * errorAt().item<double>() / square;
    ASSERT_GT(square, 0.0);
    torch::Tensor moved = numbers;
    moved.add_(step * gradient);
    const double above = errorAt().item<double>();
    moved.sub_(2.0 * step * gradient);
    const double below = errorAt().item<double>();
    moved.add_(step * gradient);
    EXPECT_NEAR((above - below) / (2.0 * step), square, 0.01 * square);
  }
}

TEST(DictionaryAt, IsTheTrilinearBlendOfTheNodes) {
  GeneratorNetwork network = codeNetwork(5, 6);
  const torch::NoGradGuard guard;
  const PointSet& points = stratumOrder().points;
  const torch::Tensor table = network->dictionaryAt(points, 100, 50);
  ASSERT_EQ(table.sizes(), torch::IntArrayRef({50, kCodeCount + 1}));
  torch::Tensor one = torch::zeros({1, kCodeCount});
  for (int i = 0; i < 50; ++i) {
    const LocalPoint at = {points.x[100 + i], points.y[100 + i], points.z[100 + i]};
    EXPECT_NEAR(table[i][kCodeCount].item<double>(), logitAt(network, one, 0, at), 1e-5) << i;
    one[0][3] = 1.0;
    EXPECT_NEAR((table[i][kCodeCount] + table[i][3]).item<double>(), logitAt(network, one, 0, at), 1e-5) << i;
    one[0][3] = 0.0;
  }
}

// The dictionary is learned with the generator: on functions that training has not seen both together err less.
TEST(TrainingOfCodes, LearnsADictionaryAndItsCodes) {
  const TrainingData training(sampleSet(150, 1), codeBasis(), codeBasis()),
      held_out(sampleSet(40, 5000), codeBasis(), codeBasis());
  TrainOptions options;
  options.steps = 400;
  options.batch = 32;
  options.learning_rate = 3e-3;
  options.average_decay = 0.98;
  options.shape = codeShape(5);
  options.shape.output_scale = 1.0;  // codes count in steps
  Representation code;
  ASSERT_TRUE(findRepresentation("code16", &code));
  TrainingState state = makeState(options, Theta(kCodeCount, 0.0f));
  const torch::Tensor dictionary = state.network->dictionary().detach().clone();
  const HeldOutError before = heldOutError(state.average, code, held_out, CheckOptions().loss(), 40);
  train(options, code, training, held_out, &state, [] {});
  const HeldOutError after = heldOutError(state.average, code, held_out, CheckOptions().loss(), 40);
  EXPECT_LT(after.network, 0.7 * before.network);
  EXPECT_FALSE(torch::equal(state.average->dictionary(), dictionary));
  // from the same seed the same numbers
  options.steps = 20;
  const auto briefly = [&] {
    TrainingState brief = makeState(options, Theta(kCodeCount, 0.0f));
    train(options, code, training, held_out, &brief, [] {});
    return brief.average->dictionary();
  };
  EXPECT_TRUE(torch::equal(briefly(), briefly()));
}

}  // namespace
}  // namespace nlg
