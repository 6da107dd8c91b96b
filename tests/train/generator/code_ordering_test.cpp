#include "train/generator/network/code_ordering.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

#include <Eigen/Dense>

#include "runtime_eval/fit/code_fit.h"
#include "tests/train/code_network.h"
#include "tool/error.h"
#include "train/generator/network/theta_stages.h"

namespace nlg {
namespace {

constexpr int kFunctions = 80;
constexpr int kResolution = 5;

const TrainingData& orderingData() {
  static const TrainingData training(sampleSet(kFunctions, 1), codeBasis(), codeBasis());
  return training;
}

torch::Tensor codesOf(GeneratorNetwork& network) {
  std::vector<Sample> samples;
  for (int n = 0; n < kFunctions; ++n) samples.push_back({n});
  const torch::NoGradGuard guard;
  return network->forward(inputBatch(orderingData(), samples)).contiguous();
}

Representation representationOf(GeneratorNetwork& network) {
  Representation code;
  EXPECT_TRUE(findRepresentation("code16", &code));
  return network->toData(code, codeBasis()).representation;
}

CodeOrderingOptions allFunctions(int threads = 1) { return {.functions = kFunctions, .tent_rmse = 0.002, .threads = threads}; }

TEST(OrderCodes, LeavesWhatIsPredictedAsItWas) {
  GeneratorNetwork network = codeNetwork(kResolution, 1);
  const torch::Tensor before = codesOf(network);
  const torch::Tensor dictionary = network->dictionary().detach().clone();
  orderCodes(orderingData(), codeBasis(), allFunctions(), &network);
  const torch::Tensor after = codesOf(network);
  EXPECT_FALSE(torch::allclose(before, after)) << "the numbers are others";
  // logits at the nodes: c and the sum over k
  const auto logits = [](const torch::Tensor& z, const torch::Tensor& nodes) {
    const torch::NoGradGuard guard;
    return torch::addmm(nodes.select(1, kCodeCount).to(torch::kDouble), z.to(torch::kDouble),
                        nodes.slice(1, 0, kCodeCount).t().to(torch::kDouble));
  };
  const torch::Tensor was = logits(before, dictionary), is = logits(after, network->dictionary().detach());
  // float, through an inverse whose condition is that of the equations
  EXPECT_LT((was - is).abs().max().item<double>(), 1e-3 * was.abs().max().item<double>());
}

// r³ x K and r³: the nodes of the b_k, and c, as a file has them.
std::pair<Eigen::MatrixXd, Eigen::VectorXd> nodesOf(const Representation& code) {
  const Dictionary& dictionary = *code.dictionary;
  Eigen::MatrixXd nodes(dictionary.nodeCount(), kCodeCount);
  Eigen::VectorXd c(dictionary.nodeCount());
  for (int n = 0; n < dictionary.nodeCount(); ++n) {
    for (int k = 0; k < kCodeCount; ++k) nodes(n, k) = dictionary.row(k)[n];
    c(n) = dictionary.row(kCodeCount)[n];
  }
  return {nodes, c};
}

// The fits that the order is made from, as codes of the ordered dictionary: the same logits in other numbers. There the mean of the codes
// is 0, that of the equations is the identity up to units, and what matters most comes first.
TEST(OrderCodes, MakesTheMeanEquationsTheIdentityUpToUnits) {
  GeneratorNetwork network = codeNetwork(kResolution, 1);
  torch::Tensor codes = codesOf(network);
  {
    const torch::NoGradGuard guard;
    network->deviations().copy_(codes.std(0, false));
  }
  const Representation before = representationOf(network);
  CodeFit fit;
  for (int n = 0; n < kFunctions; ++n) {
    const WeightingFunction function = decoded(orderingData().function(n), pointOrder(before), CodeOrderingOptions{}.loss);
    fit.iterate(before, function, {.iterations = 12, .prior = 1e-5}, kCodeCount, codes.data_ptr<float>() + n * kCodeCount);
  }
  orderCodes(orderingData(), codeBasis(), allFunctions(), &network);
  const Representation after = representationOf(network);
  const auto [old_nodes, old_c] = nodesOf(before);
  const auto [nodes, c] = nodesOf(after);
  const auto solver = nodes.colPivHouseholderQr();

  Eigen::MatrixXd equations = Eigen::MatrixXd::Zero(kCodeCount, kCodeCount);
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(kCodeCount), square = mean;
  CodeEquations one;
  CodeFitOptions without_prior;
  without_prior.prior = 0.0;
  for (int n = 0; n < kFunctions; ++n) {
    const Eigen::VectorXd old =
        Eigen::Map<const Eigen::VectorXf>(codes.data_ptr<float>() + n * kCodeCount, kCodeCount).cast<double>();
    const Eigen::VectorXd z = solver.solve(old_nodes * old + old_c - c);
    const Eigen::VectorXf as_floats = z.cast<float>();
    const WeightingFunction function = decoded(orderingData().function(n), pointOrder(after), CodeOrderingOptions{}.loss);
    fit.equationsAt(after, function, without_prior, as_floats.data(), &one);
    equations += Eigen::Map<const Eigen::MatrixXf>(one.matrix.data(), kCodeCount, kCodeCount).cast<double>() / kFunctions;
    mean += z / kFunctions;
    square += z.cwiseAbs2() / kFunctions;
  }
  const Eigen::VectorXd unit = equations.diagonal().cwiseSqrt(), deviation = square.cwiseSqrt();
  // nodes are off by half a 127th of their row's largest in both dictionaries: a hundredth or two of what numbers do
  constexpr double kOfBytes = 0.05;
  for (int i = 0; i < kCodeCount; ++i) {
    // the last numbers are differences of rows that nearly cancel, of which bytes leave less
    const double most = i < kCodeCount / 2 ? kOfBytes : 0.35;
    for (int k = 0; k < i; ++k) EXPECT_LT(std::fabs(equations(i, k)), most * unit(i) * unit(k)) << i << ", " << k;
    EXPECT_LT(std::fabs(mean(i)), kOfBytes * deviation(i)) << i;
    EXPECT_NEAR(network->deviations()[i].item<double>(), deviation(i), kOfBytes * deviation(i)) << i;
    if (i > 0) {
      EXPECT_LT(unit(i) * deviation(i), (1.0 + kOfBytes) * unit(i - 1) * deviation(i - 1)) << i;
    }
  }
  EXPECT_LT(unit(kCodeCount - 1) * deviation(kCodeCount - 1), 0.5 * unit(0) * deviation(0));
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
      for (int n = 0; n < first.nodeCount(); ++n)
        ASSERT_EQ(first.row(k)[n], second.row(k)[n]) << spread << ": " << k << ", " << n;
    }
  }
}

}  // namespace
}  // namespace nlg
