#include "train/generator/code_ordering.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

#include <Eigen/Dense>

#include "runtime_eval/fit/code_fit.h"
#include "tests/train/code_network.h"
#include "tool/error.h"
#include "train/generator/theta_stages.h"

namespace nlg {
namespace {

constexpr int kFunctions = 80;
constexpr int kResolution = 5;

const TrainingData& data() {
  static const TrainingData training(sampleSet(kFunctions, 1), codeBasis(), codeBasis());
  return training;
}

torch::Tensor codesOf(GeneratorNetwork& network) {
  std::vector<Sample> samples;
  for (int n = 0; n < kFunctions; ++n) samples.push_back({n});
  const torch::NoGradGuard guard;
  return network->forward(coefficientBatch(data(), samples)).contiguous();
}

Representation representationOf(GeneratorNetwork& network) {
  Representation code;
  EXPECT_TRUE(findRepresentation("code16", &code));
  return network->toData(code, codeBasis()).representation;
}

CodeOrderingOptions allFunctions(int threads = 1) { return {.functions = kFunctions, .tent_rmse = 0.002, .threads = threads}; }

GeneratorNetwork orderedNetwork(int threads = 1) {
  GeneratorNetwork network = codeNetwork(kResolution, 1);
  orderCodes(data(), codeBasis(), allFunctions(threads), &network);
  return network;
}

TEST(OrderCodes, LeavesWhatIsPredictedAsItWas) {
  GeneratorNetwork network = codeNetwork(kResolution, 1);
  const torch::Tensor before = codesOf(network);
  const torch::Tensor dictionary = network->dictionary().detach().clone();
  orderCodes(data(), codeBasis(), allFunctions(), &network);
  const torch::Tensor after = codesOf(network);
  EXPECT_FALSE(torch::allclose(before, after)) << "the numbers are others";
  // logits at the nodes: c and the sum over k
  const auto logits = [](const torch::Tensor& z, const torch::Tensor& nodes) {
    const torch::NoGradGuard guard;
    return torch::addmm(nodes.select(1, kCodeCount).to(torch::kDouble), z.to(torch::kDouble), nodes.slice(1, 0, kCodeCount).t().to(torch::kDouble));
  };
  const torch::Tensor was = logits(before, dictionary), is = logits(after, network->dictionary().detach());
  // float, through an inverse whose condition is that of the equations
  EXPECT_LT((was - is).abs().max().item<double>(), 1e-3 * was.abs().max().item<double>());
}

// A unit of each number stands for a change of its own. In the metric of the mean equations numbers do not mix.
TEST(OrderCodes, MakesTheMeanEquationsTheIdentityUpToUnits) {
  GeneratorNetwork network = orderedNetwork();
  const Representation code = representationOf(network);
  torch::Tensor codes = codesOf(network);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(kCodeCount, kCodeCount), square = sum;
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(kCodeCount), furthest = mean;
  CodeFit fit;
  CodeEquations equations;
  for (int n = 0; n < kFunctions; ++n) {
    float* z = codes.data_ptr<float>() + n * kCodeCount;
    const WeightingFunction function = decodeFunction(data().function(n), pointOrder(code), CodeOrderingOptions{}.dark_weight);
    fit.iterate(code, function, {.iterations = 12}, kCodeCount, z);
    fit.equationsAt(code, function, {}, z, &equations);
    sum += Eigen::Map<const Eigen::MatrixXf>(equations.matrix.data(), kCodeCount, kCodeCount).cast<double>() / kFunctions;
    const Eigen::VectorXd one = Eigen::Map<const Eigen::VectorXf>(z, kCodeCount).cast<double>();
    mean += one / kFunctions;
    square += one * one.transpose() / kFunctions;
    furthest = furthest.cwiseMax(one.cwiseAbs());
  }
  const Eigen::VectorXd scale = sum.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd normal = scale.asDiagonal() * sum * scale.asDiagonal();
  const Eigen::VectorXd variance = square.diagonal().cwiseQuotient(scale.cwiseAbs2());
  for (int i = 0; i < kCodeCount; ++i) {
    for (int k = 0; k < i; ++k) EXPECT_NEAR(normal(i, k), 0.0, 0.1) << i << ", " << k;
    // the mean code is 0, what a byte holds reaches as far as fits go
    const double deviation = std::sqrt(square(i, i));
    EXPECT_LT(std::fabs(mean(i)), 0.2 * deviation) << i;
    EXPECT_LT(furthest(i), 127.0) << i;
    EXPECT_GT(furthest(i), 60.0) << i;
    EXPECT_NEAR(network->deviations()[i].item<double>(), deviation, 0.2 * deviation) << i;
    // what is left out of a code's end costs least
    if (i > 0) {
      EXPECT_LT(variance(i), 1.2 * variance(i - 1)) << i;
    }
  }
  EXPECT_LT(variance(kCodeCount - 1), 0.2 * variance(0));
}

TEST(OrderCodes, GivesTheSameBytesOnAnyNumberOfThreads) {
  GeneratorNetwork one = orderedNetwork(1), three = orderedNetwork(3);
  EXPECT_TRUE(torch::equal(one->dictionary(), three->dictionary()));
  EXPECT_TRUE(torch::equal(one->deviations(), three->deviations()));
  EXPECT_TRUE(torch::equal(one->lastLayer()->weight, three->lastLayer()->weight));
  EXPECT_TRUE(torch::equal(one->lastLayer()->bias, three->lastLayer()->bias));
}

TEST(OrderCodes, TakesFewerFunctionsThanNumbers) {
  // a covariance without full rank: what no function needed has a unit all the same
  GeneratorNetwork network = codeNetwork(kResolution, 2);
  orderCodes(data(), codeBasis(), {.functions = 3}, &network);
  for (const torch::Tensor& parameter : network->parameters()) EXPECT_TRUE(torch::isfinite(parameter).all().item<bool>());
  const Representation code = representationOf(network);
  EXPECT_EQ(whatIsWrong(code.dictionary->data()), "");
}

TEST(OrderCodes, RefusesATrainingSetWithoutFunctionsToFit) {
  GeneratorNetwork network = codeNetwork(kResolution, 1);
  EXPECT_THROW(orderCodes(data(), codeBasis(), {.tent_rmse = 10.0}, &network), InputError);
}

TEST(GeneratorNetwork, RoundsItsDictionaryToWhatAFileHoldsWhateverItsNumbers) {
  for (const double spread : {0.0, 4.0, 30.0}) {
    GeneratorNetwork network = codeNetwork(kResolution, 4);
    {
      // rows from 2^-spread to 1
      const torch::NoGradGuard guard;
      for (int64_t k = 0; k < kCodeCount; ++k) network->dictionary().select(1, k).mul_(std::exp2(-spread * k / kCodeCount));
    }
    const DictionaryData data = representationOf(network).dictionary->data();
    EXPECT_EQ(whatIsWrong(data), "") << spread;
    // again, from what the file has
    GeneratorNetwork again = codeNetwork(kResolution, 5);
    {
      const torch::NoGradGuard guard;
      const Dictionary dictionary(data);
      for (int k = 0; k <= kCodeCount; ++k) {
        for (int n = 0; n < dictionary.nodeCount(); ++n) again->dictionary()[n][k] = dictionary.row(k)[n];
      }
    }
    const Dictionary first(data), second(representationOf(again).dictionary->data());
    for (int k = 0; k <= kCodeCount; ++k) {
      for (int n = 0; n < first.nodeCount(); ++n) ASSERT_EQ(first.row(k)[n], second.row(k)[n]) << spread << ": " << k << ", " << n;
    }
  }
}

TEST(GeneratorNetwork, RoundsADictionaryOfManyLargeRowsSoThatSumsAreExact) {
  GeneratorShape shape = codeShape(3);
  shape.code_count = 128;
  GeneratorNetwork network(shape, Theta(128, 0.0f), 6);
  {
    // all rows but one alike: of seven exponents below them sums would be beyond 2^24
    const torch::NoGradGuard guard;
    network->dictionary().select(1, 5).mul_(1.0 / 128);
  }
  Representation code;
  ASSERT_TRUE(findRepresentation("code128", &code));
  EXPECT_EQ(whatIsWrong(network->toData(code, codeBasis()).representation.dictionary->data()), "");
}

}  // namespace
}  // namespace nlg
