#include "train/generator/theta_stages.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

#include <algorithm>
#include <map>

#include "runtime_eval/fit/theta_policy.h"
#include "tests/runtime_eval/sample_generator.h"
#include "tests/train/sample_set.h"
#include "train/generator/trainer.h"

namespace nlg {
namespace {

// One whose last layer is solved, one of another output function, a field.
const Representation kTentMlp = Representation::tentMlp(0.01f);
const Representation kRepresentations[] = {kTentMlp, {RepresentationKind::tent_mlp44, 0.01f}, Representation::productField(3)};

constexpr int kSteps = 3, kTrainingCount = 150, kHeldOutCount = 40;

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
  shape.correction_steps = kSteps;
  shape.correction_width = 48;
  shape.correction_layers = 3;
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
  options.steps = 300;
  options.batch = 32;
  options.learning_rate = 3e-3;
  options.average_decay = 0.98;
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
    const ThetaStages stages = runStages(network, representation, training(), samples);
    ASSERT_EQ(stages.mean_squares.size(), size_t(1 + solveCount(representation) + kSteps)) << representationName(representation);
    torch::Tensor theta = torch::tensor(theta0).repeat({5, 1});
    const torch::Tensor generated = measureTheta(theta, {representation, training(), samples}).mean_square;
    torch::Tensor solved = generated;
    if (solveCount(representation) == 1) {
      theta = solveLastLayers(theta, {representation, training(), samples});
      solved = measureTheta(theta, {representation, training(), samples}).mean_square;
    }
    for (size_t s = 0; s < stages.mean_squares.size(); ++s) {
      EXPECT_TRUE(torch::equal(stages.mean_squares[s], s == 0 ? generated : solved))
          << representationName(representation) << ", stage " << s;
    }
  }
}

TEST(ThetaStages, AreAsManyAsTheShapeSays) {
  for (const bool solves : {false, true}) {
    for (const int steps : {0, 1, 4}) {
      GeneratorShape shape = smallShape();
      shape.exact_last_layer = solves;
      shape.correction_steps = steps;
      GeneratorNetwork network(shape, randomTheta(kTentMlp, 1), 7);
      const ThetaStages stages = runStages(network, kTentMlp, training(), allPoints(kTentMlp, 2));
      EXPECT_EQ(stages.mean_squares.size(), size_t(1 + solves + steps)) << (solves ? "solved, " : "not solved, ") << steps;
    }
  }
}

TEST(ThetaStages, NeverRiseWhenTheLastLayerIsSolved) {
  GeneratorNetwork network(smallShape(), randomTheta(kTentMlp, 1), 7);
  shake(network, 0.2);
  std::vector<Sample> samples;
  for (int n = 0; n < 60; ++n) samples.push_back({n, n % 8, n % 7, 1 + n % 2});
  const ThetaStages stages = runStages(network, kTentMlp, training(), samples);
  EXPECT_TRUE((stages.mean_squares[1] < stages.mean_squares[0]).all().item<bool>())
      << torch::stack(stages.mean_squares).slice(0, 0, 2);
}

// Slope of the summed error of a stage in the direction of its gradient by the parameters whose names begin with `prefix`: what
// autograd says, and what a central difference does.
std::pair<double, double> slopes(GeneratorNetwork& network, const Representation& representation, size_t stage,
                                 const std::string& prefix) {
  const std::vector<Sample> samples = allPoints(representation, 8);
  std::vector<torch::Tensor> parameters, gradients;
  for (auto& item : network->named_parameters()) {
    if (item.key().rfind(prefix, 0) == 0) parameters.push_back(item.value());
  }
  network->zero_grad();
  runStages(network, representation, training(), samples).mean_squares[stage].sum().backward();
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
        runStages(network, representation, training(), samples).mean_squares[stage].to(torch::kDouble).sum().item<double>();
    for (size_t i = 0; i < parameters.size(); ++i) parameters[i].sub_(step / norm * gradients[i]);
    return error;
  };
  const double step = 1e-3 * errorAt(0) / norm;  // changes the error by a thousandth: far above its rounding
  return {norm, (errorAt(step) - errorAt(-step)) / (2 * step)};
}

TEST(ThetaStages, HaveTheGradientOfFiniteDifferences) {
  for (const Representation& representation : kRepresentations) {
    GeneratorShape shape = smallShape();
    shape.correction_steps = 1;  // what a later step reads depends on the steps before: a path that the gradient leaves out
    GeneratorNetwork network(shape, randomTheta(representation, 1), 7);
    shake(network, 0.05);
    const size_t solved = static_cast<size_t>(solveCount(representation));
    std::vector<std::pair<size_t, std::string>> cases = {{0, "layer"}, {solved + 1, "correction"}};
    if (solved) cases.push_back({1, "layer"});  // the solution of the last layer as a constant loses nothing
    for (const auto& [stage, prefix] : cases) {
      const auto [claimed, measured] = slopes(network, representation, stage, prefix);
      EXPECT_NEAR(measured, claimed, 0.01 * claimed)
          << representationName(representation) << ", stage " << stage << " by " << prefix;
    }
  }
}

TEST(ThetaStages, ReachTheGeneratorThroughThetaAlone) {
  // without a solved layer the gradient of a corrected theta by the generator is that of a theta that is so much further on
  const Representation& representation = kRepresentations[1];
  GeneratorShape shape = smallShape();
  shape.correction_steps = 1;
  GeneratorNetwork network(shape, randomTheta(representation, 1), 7);
  shake(network, 0.05);
  const std::vector<Sample> samples = allPoints(representation, 8);
  const auto gradientOf = [&](const torch::Tensor& errors) {
    network->zero_grad();
    errors.sum().backward();
    return network->named_parameters()["layer1.weight"].grad().clone();
  };
  const torch::Tensor gradient = gradientOf(runStages(network, representation, training(), samples).mean_squares[1]);

  const torch::Tensor coefficients = coefficientBatch(training(), samples), theta = network->forward(coefficients);
  const ThetaErrors errors = measureTheta(theta, {representation, training(), samples});
  const torch::Tensor features = network->correctionFeatures(coefficients, theta.detach(), errors.mean_square, errors.gradient);
  const torch::Tensor further = theta + network->correction(features).detach();
  const torch::Tensor expected =
      gradientOf(differentiable(measureTheta(further, {representation, training(), samples}), further));
  EXPECT_GT(expected.abs().max().item<float>(), 0.0f);
  EXPECT_TRUE(torch::allclose(gradient, expected, 1e-5, 1e-7));
}

TEST(ThetaStages, LeaveTheGeneratedLastLayerAloneOnceItIsSolved) {
  GeneratorNetwork network(smallShape(), randomTheta(kTentMlp, 1), 7);
  shake(network, 0.05);
  const ThetaStages stages = runStages(network, kTentMlp, training(), allPoints(kTentMlp, 8));
  for (size_t s = 1; s < stages.mean_squares.size(); ++s) {
    network->zero_grad();
    stages.mean_squares[s].sum().backward({}, /*retain_graph=*/true);
    const torch::Tensor gradient = network->named_parameters()["layer2.weight"].grad();
    EXPECT_EQ(gradient.slice(0, ThetaLayout::w3).abs().max().item<float>(), 0.0f) << "stage " << s;
    EXPECT_GT(gradient.slice(0, 0, ThetaLayout::w3).abs().max().item<float>(), 0.0f) << "stage " << s;
  }
}

TEST(ThetaStages, LearnToCorrectFunctionsThatTrainingHasNotSeen) {
  for (const Representation& representation : kRepresentations) {
    GeneratorNetwork untrained(smallShape(), startTheta(representation), 1);
    const HeldOutError before = heldOutError(untrained, representation, heldOut(), kHeldOutCount);
    const HeldOutError after = heldOutError(trained(representation), representation, heldOut(), kHeldOutCount);
    // 300 steps on 150 functions: the generator alone has not come far
    EXPECT_LT(after.network, 0.9 * before.network) << representationName(representation);
    EXPECT_LT(after.final, 0.8 * before.final) << representationName(representation);
    EXPECT_LT(after.final, 0.9 * after.network) << representationName(representation);

    // corrections pay on average, beyond what solving gives; the later ones next to nothing after so short a training, but they
    // do no harm either
    torch::NoGradGuard guard;
    const ThetaStages stages =
        runStages(trained(representation), representation, heldOut(), allPoints(representation, kHeldOutCount));
    const auto mean = [&](size_t s) { return stages.mean_squares[s].sqrt().mean().item<double>(); };
    const size_t first = static_cast<size_t>(solveCount(representation)) + 1;
    EXPECT_LT(mean(first), mean(first - 1)) << representationName(representation);
    for (size_t s = first + 1; s < stages.mean_squares.size(); ++s) {
      EXPECT_LT(mean(s), 1.005 * mean(s - 1)) << representationName(representation) << ", stage " << s;
    }
  }
}

TEST(HeldOutError, IsTheMeanOverFunctionsOfTheBestStage) {
  GeneratorNetwork& network = trained(kTentMlp);
  torch::NoGradGuard guard;
  const ThetaStages stages = runStages(network, kTentMlp, heldOut(), allPoints(kTentMlp, kHeldOutCount));
  double generated = 0.0, final = 0.0;
  for (int n = 0; n < kHeldOutCount; ++n) {
    double least = INFINITY;
    for (const torch::Tensor& stage : stages.mean_squares) least = std::min(least, stage[n].item<double>());
    generated += std::sqrt(stages.mean_squares[0][n].item<double>()) / kHeldOutCount;
    final += std::sqrt(least) / kHeldOutCount;
  }
  const HeldOutError error = heldOutError(network, kTentMlp, heldOut(), 2048);
  EXPECT_NEAR(error.network, generated, 1e-6 * generated);
  EXPECT_NEAR(error.final, final, 1e-6 * final);
}

// Training sees every stage of theta; at bake time the steps of a function end when one does not lower its mean square by a
// hundredth.
// before   of the theta from which the last step was taken
double errorAtBakeTime(const ThetaStages& stages, int solve_count, int64_t n, int* steps_taken, double* before) {
  const auto at = [&](size_t s) { return stages.mean_squares[s][n].item<double>(); };
  double least = at(0);
  size_t s = 1;
  // solving is no step: its error may be what it likes
  if (solve_count > 0) least = std::min(least, at(s++));
  *steps_taken = 0;
  for (bool paid = true; paid && s < stages.mean_squares.size(); ++s, ++*steps_taken) {
    paid = at(s) < 0.99 * least;
    *before = at(s - 1);
    least = std::min(least, at(s));
  }
  return least;
}

TEST(ThetaStages, AreThoseOfBakeTime) {
  for (const Representation& representation : kRepresentations) {
    GeneratorNetwork& network = trained(representation);
    torch::NoGradGuard guard;
    const ThetaStages stages = runStages(network, representation, heldOut(), allPoints(representation, kHeldOutCount));

    const Generator generator(network->toData(representation, basis()));
    ASSERT_EQ(generator.correctionStepCount(), kSteps);
    ASSERT_EQ(generator.exactLastLayer(), solveCount(representation) == 1);
    const size_t D = static_cast<size_t>(representation.thetaCount());
    std::vector<float> theta(kHeldOutCount * D);
    std::vector<StoredFunction> functions;
    for (int n = 0; n < kHeldOutCount; ++n) functions.push_back(heldOut().function(n));
    PolicyOptions options;
    options.stages = {.good_rmse = 0.0,
                      .learned_steps = kSteps,
                      .mirror_images = 1,
                      .lm_iterations = 0,
                      .lm_theta0_iterations = 0,
                      .adam_steps = 0};
    // nothing passes, so that no theta is put back for its leaks
    options.refinement.check.tau_rmse = 1e-9;
    std::vector<ThetaRecord> records(kHeldOutCount);
    StageRunner(generator, options).make(functions.data(), kHeldOutCount, theta.data(), records.data());

    int went_all_the_way = 0;
    std::vector<double> differences;
    for (int n = 0; n < kHeldOutCount; ++n) {
      int steps_taken = 0;
      double before = 0.0;
      const double expected = errorAtBakeTime(stages, solveCount(representation), n, &steps_taken, &before);
      went_all_the_way += steps_taken == kSteps;
      const double rmse = functionRmse(representation, decodeFunction(functions[n], pointOrder(representation)), &theta[n * D]);
      differences.push_back(std::abs(rmse * rmse - expected) / expected);
      // a step that removes nearly all of an error removes it to a share of what it was, by the rounding of theta and its gradient
      EXPECT_LT(std::abs(rmse * rmse - expected), 1e-2 * std::max(before, expected))
          << representationName(representation) << ", function " << n;
    }
    // roundings, which steep last layers carry on: as a rule by little
    std::nth_element(differences.begin(), differences.begin() + kHeldOutCount / 2, differences.end());
    EXPECT_LT(differences[kHeldOutCount / 2], 1e-4) << representationName(representation);
    EXPECT_GT(went_all_the_way, kHeldOutCount / 4)
        << representationName(representation) << ": too few to say anything about the later steps";
  }
}

}  // namespace
}  // namespace nlg
