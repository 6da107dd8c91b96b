#include "train/generator/network/theta_stages.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

#include <map>

#include "runtime_eval/evaluator/generator/generator_data.h"
#include "runtime_eval/policy/stage_runner.h"
#include "tests/runtime_eval/sample_generator.h"
#include "tests/train/sample_set.h"
#include "train/generator/run/trainer.h"

namespace nlg {
namespace {

// One whose last layer is solved, one of another output function, a field.
const Representation kTentMlp = Representation::tentMlp(0.01f);
const Representation kRepresentations[] = {kTentMlp, {RepresentationKind::tent_mlp44, 0.01f}, Representation::productField(3)};

constexpr int kTrainingCount = 150, kHeldOutCount = 40;

const BasisData& basis() {
  static const BasisData data = sampleBasis(kSampleClasses, 3);
  return data;
}
const TrainingData& training() {
  static const TrainingData data(sampleSet(kTrainingCount, 1), basis(), basis());
  return data;
}
const TrainingData& heldOut() {
  static const TrainingData data(sampleSet(kHeldOutCount, 5000), basis(), basis());
  return data;
}

GeneratorShape smallShape() {
  GeneratorShape shape;
  shape.coefficient_count = basis().coefficientCount();
  shape.width = 32;
  shape.layer_count = 3;
  return shape;
}

// Every number of a network a little off, those that start at zero too.
void shake(GeneratorNetwork& network, double deviation) {
  torch::NoGradGuard guard;
  torch::manual_seed(3);
  for (torch::Tensor& parameter : network->parameters()) parameter.add_(deviation * torch::randn_like(parameter));
}

std::vector<Sample> allPoints(const Representation& representation, int count) {
  std::vector<Sample> samples;
  for (int n = 0; n < count; ++n) samples.push_back({.function = n, .batch_count = pointOrder(representation).batchCount()});
  return samples;
}

int solveCount(const Representation& representation) { return representation.kind == RepresentationKind::tent_mlp ? 1 : 0; }

// Where training begins: random, but for the output of networks with a sigmoid, which stands open. A sigmoid that is shut for every
// function has no gradient to learn from.
Theta startTheta(const Representation& representation) {
  Theta theta = randomTheta(representation, 2);
  if (!representation.isField() && representation.shape().output == OutputFunction::sigmoid) {
    const NetworkShape& shape = representation.shape();
    for (int i = shape.w3(); i < shape.b3(); ++i) theta[i] *= 0.3f;
    theta[shape.b3()] = 1.0f;
  }
  return theta;
}

// A generator that has been trained on the sample functions; one a representation, made when it is first asked for.
GeneratorNetwork& trained(const Representation& representation) {
  static std::map<std::string, GeneratorNetwork> networks;
  const auto known = networks.find(representationName(representation));
  if (known != networks.end()) return known->second;
  TrainOptions options;
  options.steps = 200;
  options.batch = 32;
  options.learning_rate = 3e-3;
  options.average_decay = 0.98;
  options.loss = kUnweighed;  // so few steps of so few functions do not come to walls
  options.shape = smallShape();
  TrainingState state = makeState(options, startTheta(representation));
  train(options, representation, training(), heldOut(), &state, [] {});
  return networks.emplace(representationName(representation), state.average).first->second;
}

TEST(ThetaStages, AreOnesOfTheta0BeforeTraining) {
  for (const Representation& representation : kRepresentations) {
    const Theta theta0 = randomTheta(representation, 1);
    GeneratorNetwork network(smallShape(), theta0, 7);
    const std::vector<Sample> samples = allPoints(representation, 5);
    const std::vector<torch::Tensor> stages = runStages(network, representation, training(), samples, kUnweighed);
    ASSERT_EQ(stages.size(), size_t(1 + solveCount(representation))) << representationName(representation);
    torch::Tensor theta = torch::tensor(theta0).repeat({5, 1});
    const torch::Tensor generated = measureTheta(theta, {representation, training(), samples, kUnweighed}).mean_square;
    torch::Tensor solved = generated;
    if (solveCount(representation) == 1) {
      theta = solveLastLayers(theta, {representation, training(), samples, kUnweighed});
      solved = measureTheta(theta, {representation, training(), samples, kUnweighed}).mean_square;
    }
    for (size_t s = 0; s < stages.size(); ++s) {
      EXPECT_TRUE(torch::equal(stages[s], s == 0 ? generated : solved)) << representationName(representation) << ", stage " << s;
    }
  }
}

TEST(ThetaStages, NeverRiseWhenTheLastLayerIsSolved) {
  GeneratorNetwork network(smallShape(), randomTheta(kTentMlp, 1), 7);
  shake(network, 0.2);
  std::vector<Sample> samples;
  for (int n = 0; n < 60; ++n) samples.push_back({n, n % 8, n % 7, 1 + n % 2});
  const std::vector<torch::Tensor> stages = runStages(network, kTentMlp, training(), samples, kUnweighed);
  EXPECT_TRUE((stages[1] < stages[0]).all().item<bool>()) << torch::stack(stages).slice(0, 0, 2);
}

// Slope of the summed error of a stage in the direction of its gradient by the parameters: what autograd says, and what a central
// difference does.
std::pair<double, double> slopes(GeneratorNetwork& network, const Representation& representation, size_t stage) {
  const std::vector<Sample> samples = allPoints(representation, 8);
  std::vector<torch::Tensor> parameters = network->parameters(), gradients;
  network->zero_grad();
  runStages(network, representation, training(), samples, kUnweighed)[stage].sum().backward();
  double square = 0.0;
  for (const torch::Tensor& parameter : parameters) {
    gradients.push_back(parameter.grad().clone());
    square += parameter.grad().square().sum().item<double>();
  }
  const double norm = std::sqrt(square);
  torch::NoGradGuard guard;
  const auto errorAt = [&](double step) {
    for (size_t i = 0; i < parameters.size(); ++i) parameters[i].add_(step / norm * gradients[i]);
    const double error =
        runStages(network, representation, training(), samples, kUnweighed)[stage].to(torch::kDouble).sum().item<double>();
    for (size_t i = 0; i < parameters.size(); ++i) parameters[i].sub_(step / norm * gradients[i]);
    return error;
  };
  const double step = 1e-3 * errorAt(0) / norm;  // changes the error by a thousandth: far above its rounding
  return {norm, (errorAt(step) - errorAt(-step)) / (2 * step)};
}

TEST(ThetaStages, HaveTheGradientOfFiniteDifferences) {
  for (const Representation& representation : kRepresentations) {
    GeneratorNetwork network(smallShape(), randomTheta(representation, 1), 7);
    shake(network, 0.05);
    // the solution of the last layer as a constant loses nothing
    for (int stage = 0; stage <= solveCount(representation); ++stage) {
      const auto [claimed, measured] = slopes(network, representation, static_cast<size_t>(stage));
      EXPECT_NEAR(measured, claimed, 0.01 * claimed) << representationName(representation) << ", stage " << stage;
    }
  }
}

TEST(ThetaStages, LearnFunctionsThatTrainingHasNotSeen) {
  for (const Representation& representation : kRepresentations) {
    GeneratorNetwork untrained(smallShape(), startTheta(representation), 1);
    const HeldOutError before = heldOutError(untrained, representation, heldOut(), kUnweighed, kHeldOutCount);
    const HeldOutError after = heldOutError(trained(representation), representation, heldOut(), kUnweighed, kHeldOutCount);
    // 200 steps on 150 functions: the generator has not come far
    EXPECT_LT(after.network, 0.9 * before.network) << representationName(representation);
    EXPECT_LT(after.final, 0.9 * before.final) << representationName(representation);
    if (solveCount(representation) == 1) {
      EXPECT_LT(after.final, 0.9 * after.network);
    }
  }
}

TEST(ThetaStages, AreThoseOfBakeTime) {
  for (const Representation& representation : kRepresentations) {
    GeneratorNetwork& network = trained(representation);
    torch::NoGradGuard guard;
    const std::vector<torch::Tensor> stages =
        runStages(network, representation, heldOut(), allPoints(representation, kHeldOutCount), kUnweighed);
    const torch::Tensor least = std::get<0>(torch::stack(stages).min(0));

    const Generator generator(network->toData(representation, basis()));
    ASSERT_EQ(generator.exactLastLayer(), solveCount(representation) == 1);
    const size_t D = static_cast<size_t>(representation.thetaCount());
    std::vector<float> theta(kHeldOutCount * D);
    std::vector<StoredFunction> functions;
    for (int n = 0; n < kHeldOutCount; ++n) functions.push_back(heldOut().function(n));
    PolicyOptions options;
    options.good_rmse = 0.0;
    // nothing passes, so that no theta is put back
    options.tau_rmse = 1e-9;
    // as the stages above were judged
    options.dark_weight = options.blend_floor = 1.0;
    std::vector<ThetaRecord> records(kHeldOutCount);
    StageRunner(generator, options, ThetaStage::last_layer).make(functions.data(), kHeldOutCount, theta.data(), records.data());
    for (int n = 0; n < kHeldOutCount; ++n) {
      const double expected = least[n].item<double>();
      const double rmse = functionRmse(representation, decoded(functions[n], pointOrder(representation)), &theta[n * D]);
      // of a thousand roundings of coefficients, theta and values, each of 2^-24
      EXPECT_NEAR(rmse * rmse, expected, 1e-3 * expected) << representationName(representation) << ", function " << n;
    }
  }
}

}  // namespace
}  // namespace nlg
