#include "train/generator/network/code_ordering.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <vector>

#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/fit/code_fit.h"
#include "tool/error.h"
#include "tool/parallel_for.h"
#include "train/generator/network/theta_stages.h"

namespace nlg {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

constexpr int kIterations = 12;
// Of the fits that say how far codes spread: loose enough that they show what functions want, and not what the prior allows.
constexpr double kLoosePrior = 1e-5;
constexpr double kWithin = 0.99;  // of the codes, by number, lie within bytes
constexpr double kRidge = 1e-6;   // of the mean diagonal entry of the equations
// Equations are summed in so many parts, each by one thread and in its order: the sum is the same on any number of threads.
constexpr size_t kSumParts = 32;

// What the fits have come to.
struct FittedCodes {
  Matrix codes;      // a row a function
  Matrix equations;  // their mean
};

// Codes that the network predicts, a row a function.
torch::Tensor predictedCodes(const TrainingData& training, const std::vector<Sample>& samples, GeneratorNetwork& network) {
  const torch::NoGradGuard guard;
  std::vector<torch::Tensor> parts;
  for (size_t first = 0; first < samples.size(); first += kBatchCount) {
    const auto begin = samples.begin() + static_cast<ptrdiff_t>(first);
    parts.push_back(network->forward(
        inputBatch(training, {begin, begin + static_cast<ptrdiff_t>(std::min<size_t>(kBatchCount, samples.size() - first))})));
  }
  return torch::cat(parts).contiguous();
}

Representation codeOf(GeneratorNetwork& network, const BasisData& basis) {
  Representation code;
  code.kind = RepresentationKind::code;
  code.code_count = network->shape().code_count;
  return network->toData(code, basis).representation;
}

FittedCodes fitAll(const TrainingData& training, const std::vector<Sample>& samples, const Representation& code, double prior,
                   const CodeOrderingOptions& options, GeneratorNetwork& network) {
  const int K = code.code_count;
  torch::Tensor codes = predictedCodes(training, samples, network);
  const CodeFitOptions fit_options{.iterations = kIterations, .prior = prior};
  struct Worker {
    CodeFit fit;
    CodeEquations equations;
  };
  std::vector<Worker> workers(static_cast<size_t>(options.threads));
  std::vector<Matrix> sums(kSumParts, Matrix::Zero(K, K));
  parallelFor(kSumParts, options.threads, [&](uint64_t part, int thread) {
    Worker& worker = workers[static_cast<size_t>(thread)];
    for (size_t i = part * samples.size() / kSumParts; i < (part + 1) * samples.size() / kSumParts; ++i) {
      // from the predicted code, as in a bake
      float* z = codes.data_ptr<float>() + static_cast<int64_t>(i) * K;
      const WeightingFunction function = decodeFunction(training.function(samples[i].function), pointOrder(code), options.loss);
      worker.fit.iterate(code, function, fit_options, K, z);
      worker.fit.equationsAt(code, function, fit_options, z, &worker.equations);
      sums[part] += Eigen::Map<const Eigen::MatrixXf>(worker.equations.matrix.data(), K, K).cast<double>();
    }
  });
  FittedCodes fitted;
  using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  fitted.codes = Eigen::Map<const RowMajor>(codes.data_ptr<float>(), codes.size(0), K).cast<double>();
  fitted.equations = Matrix::Zero(K, K);
  for (const Matrix& sum : sums) fitted.equations += sum / static_cast<double>(samples.size());
  return fitted;
}

torch::Tensor toTensor(const Matrix& matrix) {
  torch::Tensor tensor = torch::empty({matrix.rows(), matrix.cols()});
  for (int64_t i = 0; i < matrix.rows(); ++i) {
    for (int64_t k = 0; k < matrix.cols(); ++k)
      tensor.data_ptr<float>()[i * matrix.cols() + k] = static_cast<float>(matrix(i, k));
  }
  return tensor;
}

// The numbers become forward (z - centre), and the dictionary what leaves every function as it was.
void changeNumbers(const Matrix& forward, const Vector& centre, GeneratorNetwork& network) {
  const int64_t K = forward.rows();
  const double scale = network->shape().output_scale;
  torch::nn::Linear& last = network->lastLayer();
  const torch::Tensor turn = toTensor(forward), middle = toTensor(centre).view({K}), theta0 = network->named_buffers()["theta0"];
  last->bias.copy_(torch::mv(turn, last->bias + (theta0 - middle) / scale));
  last->weight.copy_(torch::mm(turn, last->weight));
  theta0.zero_();
  torch::Tensor& dictionary = network->dictionary();
  const torch::Tensor nodes = dictionary.slice(1, 0, K).clone();
  dictionary.select(1, K).add_(torch::mv(nodes, middle));
  dictionary.slice(1, 0, K).copy_(torch::mm(nodes, toTensor(forward.inverse())));
}

// A 127th of how far all but a few codes go in each number. Those few are stored in coarser steps (theta_form.h).
Vector unitsOf(const Matrix& codes) {
  Vector units(codes.cols());
  std::vector<double> magnitudes(static_cast<size_t>(codes.rows()));
  const auto within = static_cast<ptrdiff_t>(kWithin * static_cast<double>(magnitudes.size() - 1));
  for (int64_t k = 0; k < codes.cols(); ++k) {
    for (int64_t i = 0; i < codes.rows(); ++i) magnitudes[static_cast<size_t>(i)] = std::fabs(codes(i, k));
    std::nth_element(magnitudes.begin(), magnitudes.begin() + within, magnitudes.end());
    units[k] = std::max(1e-6, magnitudes[static_cast<size_t>(within)] / kMostCodeSteps);
  }
  return units;
}

}  // namespace

void orderCodes(const TrainingData& training, const BasisData& basis, const CodeOrderingOptions& options,
                GeneratorNetwork* network) {
  const std::vector<uint32_t> functions = training.functionsAbove(options.tent_rmse);
  if (functions.empty()) throw InputError("training set", "functions", "at least one that takes a theta", "none");
  const size_t count = std::min<size_t>(functions.size(), static_cast<size_t>(options.functions));
  std::vector<Sample> samples;
  for (size_t i = 0; i < count; ++i) samples.push_back({.function = functions[i * functions.size() / count]});
  const torch::NoGradGuard guard;
  (*network)->to(torch::kCPU);
  // deviations of the prior, from predicted codes until fits say more
  (*network)->deviations().copy_(predictedCodes(training, samples, *network).std(0, false).clamp_min(1e-3));
  const FittedCodes loose = fitAll(training, samples, codeOf(*network, basis), kLoosePrior, options, *network);

  // the order of docs/theory/representations.md §9: mean equations the identity, covariance diagonal and falling
  const int64_t K = loose.codes.cols();
  const Vector mean = loose.codes.colwise().mean();
  const Matrix centred = loose.codes.rowwise() - mean.transpose();
  const Matrix covariance = centred.transpose() * centred / static_cast<double>(count);
  // a ridge, where some combination of numbers moves no function
  const double ridge = kRidge * loose.equations.trace() / static_cast<double>(K);
  const Matrix lower = Eigen::LLT<Matrix>(loose.equations + ridge * Matrix::Identity(K, K)).matrixL();
  const Eigen::SelfAdjointEigenSolver<Matrix> components(lower.transpose() * covariance * lower);
  // largest first
  const Matrix forward = components.eigenvectors().rowwise().reverse().transpose() * lower.transpose();
  const Matrix ordered = centred * forward.transpose();
  Vector unit = unitsOf(ordered);
  changeNumbers(unit.cwiseInverse().asDiagonal() * forward, mean, *network);
  // deviations of the prior, in the units that numbers have by then
  const auto setDeviations = [&] {
    const Vector square = ordered.colwise().squaredNorm().transpose() / static_cast<double>(count);
    (*network)->deviations().copy_(toTensor(square.cwiseSqrt().cwiseQuotient(unit).cwiseMax(1e-3)).view({K}));
  };
  setDeviations();

  // how far codes go in fits as bakes have them
  const FittedCodes held = fitAll(training, samples, codeOf(*network, basis), CodeFitOptions().prior, options, *network);
  const Vector narrower = unitsOf(held.codes);
  changeNumbers(narrower.cwiseInverse().asDiagonal().toDenseMatrix(), Vector::Zero(K), *network);
  unit = unit.cwiseProduct(narrower);
  setDeviations();
}

}  // namespace nlg
