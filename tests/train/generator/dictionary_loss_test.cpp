#include "train/generator/network/theta_stages.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

#include "tests/runtime_eval/sample_generator.h"
#include "tests/train/code_network.h"
#include "train/generator/run/trainer.h"

namespace nlg {
namespace {

const TrainingData& data() {
  static const TrainingData training(sampleSet(6, 1), codeBasis(), codeBasis());
  return training;
}

// Mirrored in places.
std::vector<Sample> samples() { return {{0, 0}, {1, 3}, {2, 7}, {5, 0}}; }

torch::Tensor someCodes(int count, uint64_t seed) {
  torch::manual_seed(seed);
  return 4.0 * torch::randn({count, kCodeCount});
}

// From the formulas, point by point, in double.
double expected(GeneratorNetwork& network, const torch::Tensor& z, int64_t row, int batch, double dark_weight) {
  const PointOrder& order = stratumOrder();
  const Sample sample = samples()[static_cast<size_t>(row)];
  const int first = batch < 0 ? 0 : order.batch_begin[batch], end = batch < 0 ? order.placeCount() : order.batch_begin[batch + 1];
  double sum = 0.0;
  int valid = 0;
  for (int b = batch < 0 ? 0 : batch; b < (batch < 0 ? order.batchCount() : batch + 1); ++b) {
    const int begin = order.batch_begin[b], count = order.batch_begin[b + 1] - begin;
    std::vector<float> phi(static_cast<size_t>(count)), mask(static_cast<size_t>(count));
    decodeBatch(order, b, data().function(sample.function), sample.mirror, LossWeights(kUnweighed), phi.data(), mask.data());
    for (int i = 0; i < count; ++i) {
      if (mask[i] == 0.0f) continue;
      ++valid;
      const LocalPoint at = {order.points.x[begin + i], order.points.y[begin + i], order.points.z[begin + i]};
      const double bare = tent(at), value = bare / (1.0 + std::exp(-logitAt(network, z, row, at)));
      // bytes may lie a rounding above the tent
      const double residual = value - std::min<double>(phi[i], bare);
      sum += (phi[i] == 0.0f && bare > kRimTent ? dark_weight : 1.0) * residual * residual;
    }
  }
  EXPECT_LT(first, end);
  return sum / valid;
}

TEST(CodeMeanSquares, AreThoseOfTheFormulas) {
  GeneratorNetwork network = codeNetwork(5, 1);
  const torch::Tensor z = someCodes(4, 2);
  const torch::NoGradGuard guard;
  for (const double dark_weight : {1.0, 64.0}) {
    for (const int batch : {-1, 0, 5}) {
      const torch::Tensor got = codeMeanSquares(network, z, data(), samples(), batch, {.loss = {dark_weight, 1.0}});
      ASSERT_EQ(got.sizes(), torch::IntArrayRef({4}));
      for (int64_t row = 0; row < 4; ++row) {
        const double wanted = expected(network, z, row, batch, dark_weight);
        // sums of up to 8192 floats, each product of a few roundings
        EXPECT_NEAR(got[row].item<double>(), wanted, 1e-4 * wanted)
            << "row " << row << ", batch " << batch << ", dark " << dark_weight;
      }
    }
  }
}

// The slope in the direction of the gradient: what autograd says, and what a central difference does.
TEST(CodeMeanSquares, HaveTheGradientOfFiniteDifferences) {
  GeneratorNetwork network = codeNetwork(5, 3);
  torch::Tensor z = someCodes(4, 4).requires_grad_();
  const auto errorAt = [&] {
    return codeMeanSquares(network, z, data(), samples(), -1, {.loss = {64.0, 1.0}}).to(torch::kDouble).sum();
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

// A leak changes no value. It moves what the sigmoid has shut, and pushes nothing that is far out further out.
TEST(CodeMeanSquares, LeakOnlyIntoTheSlope) {
  GeneratorNetwork network = codeNetwork(5, 5);
  {
    const torch::NoGradGuard guard;
    network->dictionary().zero_();
  }
  const torch::Tensor z = torch::zeros({4, kCodeCount});
  const auto slopeAt = [&](double logit, double leak, double* value) {
    {
      const torch::NoGradGuard guard;
      network->dictionary().select(1, kCodeCount).fill_(logit);
    }
    network->zero_grad();
    const torch::Tensor error = codeMeanSquares(network, z, data(), samples(), -1, {.leak = leak, .loss = kUnweighed}).sum();
    error.backward();
    *value = error.item<double>();
    return network->dictionary().grad().select(1, kCodeCount).sum().item<double>();
  };
  double value = 0.0, leaked = 0.0;
  for (const double logit : {-30.0, -2.0, 0.0, 2.0, 30.0}) {
    const double slope = slopeAt(logit, 0.0, &value), with_leak = slopeAt(logit, 0.25, &leaked);
    EXPECT_EQ(leaked, value) << logit;
    if (std::fabs(logit) < 3.0) continue;
    // shut everywhere: without a leak nothing moves. All dark, points that should be lit pull up; all lit, dark ones pull down
    EXPECT_LT(std::fabs(slope), 1e-9) << logit;
    EXPECT_GT(with_leak * (logit > 0 ? 1.0 : -1.0), 1e-3) << logit;
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
  TrainingState again = makeState(options, Theta(kCodeCount, 0.0f));
  train(options, code, training, held_out, &again, [] {});
  EXPECT_TRUE(torch::equal(again.average->dictionary(), state.average->dictionary()));
}

}  // namespace
}  // namespace nlg
