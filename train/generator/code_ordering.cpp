#include "train/generator/code_ordering.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <vector>

#include "runtime_eval/fit/code_fit.h"
#include "tool/error.h"
#include "tool/parallel_for.h"
#include "train/generator/theta_stages.h"

namespace nlg {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

constexpr int kIterations = 12;
// Beyond the furthest fit of the training set: other scenes have other functions.
constexpr double kRangeMargin = 1.25;
constexpr double kRidge = 1e-6;  // of the mean diagonal entry of the equations

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
        coefficientBatch(training, {begin, begin + static_cast<ptrdiff_t>(std::min<size_t>(kBatchCount, samples.size() - first))})));
  }
  return torch::cat(parts).contiguous();
}

FittedCodes fitAll(const TrainingData& training, const std::vector<Sample>& samples, const Representation& code, torch::Tensor& codes,
                   const CodeOrderingOptions& options) {
  const int K = code.code_count;
  const int64_t count = codes.size(0);
  struct Worker {
    CodeFit fit;
    CodeEquations equations;
    Matrix sum;
  };
  std::vector<Worker> workers(static_cast<size_t>(options.threads));
  for (Worker& worker : workers) worker.sum = Matrix::Zero(K, K);
  parallelFor(samples.size(), options.threads, [&](uint64_t i, int thread) {
    Worker& worker = workers[static_cast<size_t>(thread)];
    float* z = codes.data_ptr<float>() + static_cast<int64_t>(i) * K;
    const WeightingFunction function =
        decodeFunction(training.function(samples[i].function), pointOrder(code), options.dark_weight);
    worker.fit.iterate(code, function, {.iterations = kIterations}, K, z);
    worker.fit.equationsAt(code, function, {}, z, &worker.equations);
    worker.sum += Eigen::Map<const Eigen::MatrixXf>(worker.equations.matrix.data(), K, K).cast<double>();
  });
  FittedCodes fitted;
  using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  fitted.codes = Eigen::Map<const RowMajor>(codes.data_ptr<float>(), count, K).cast<double>();
  fitted.equations = Matrix::Zero(K, K);
  for (const Worker& worker : workers) fitted.equations += worker.sum / static_cast<double>(count);
  return fitted;
}

torch::Tensor toTensor(const Matrix& matrix) {
  torch::Tensor tensor = torch::empty({matrix.rows(), matrix.cols()});
  for (int64_t i = 0; i < matrix.rows(); ++i) {
    for (int64_t k = 0; k < matrix.cols(); ++k) tensor.data_ptr<float>()[i * matrix.cols() + k] = static_cast<float>(matrix(i, k));
  }
  return tensor;
}

}  // namespace

void orderCodes(const TrainingData& training, const BasisData& basis, const CodeOrderingOptions& options, GeneratorNetwork* network) {
  const std::vector<uint32_t> functions = training.functionsAbove(options.tent_rmse);
  if (functions.empty()) throw InputError("training set", "functions", "at least one that takes a theta", "none");
  const size_t count = std::min<size_t>(functions.size(), static_cast<size_t>(options.functions));
  std::vector<Sample> samples;
  for (size_t i = 0; i < count; ++i) samples.push_back({.function = functions[i * functions.size() / count]});
  torch::Tensor codes = predictedCodes(training, samples, *network);
  const torch::NoGradGuard guard;
  (*network)->deviations().copy_(codes.std(0, false).clamp_min(1e-3));
  Representation code;
  code.kind = RepresentationKind::code;
  code.code_count = (*network)->shape().code_count;
  code = (*network)->toData(code, basis).representation;
  const FittedCodes fitted = fitAll(training, samples, code, codes, options);

  const int K = code.code_count;
  const Vector mean = fitted.codes.colwise().mean();
  const Matrix centred = fitted.codes.rowwise() - mean.transpose();
  const Matrix covariance = centred.transpose() * centred / static_cast<double>(count);
  const double ridge = kRidge * fitted.equations.trace() / K;
  const Matrix lower = Eigen::LLT<Matrix>(fitted.equations + ridge * Matrix::Identity(K, K)).matrixL();
  const Eigen::SelfAdjointEigenSolver<Matrix> components(lower.transpose() * covariance * lower);
  // largest first
  const Matrix axes = components.eigenvectors().rowwise().reverse();
  Matrix forward = axes.transpose() * lower.transpose();
  const Matrix ordered = centred * forward.transpose();
  Vector unit(K), deviation(K);
  for (int k = 0; k < K; ++k) {
    unit[k] = std::max(1e-6, kRangeMargin * ordered.col(k).cwiseAbs().maxCoeff() / kMostCodeSteps);
    deviation[k] = std::max(1e-3, std::sqrt(ordered.col(k).squaredNorm() / static_cast<double>(count)) / unit[k]);
  }
  const Matrix to_codes = unit.cwiseInverse().asDiagonal() * forward;
  const Matrix from_codes = forward.inverse() * unit.asDiagonal();

  const double scale = (*network)->shape().output_scale;
  torch::nn::Linear& last = (*network)->lastLayer();
  const torch::Tensor turn = toTensor(to_codes), centre = toTensor(mean).view({K}), theta0 = (*network)->named_buffers()["theta0"];
  last->bias.copy_(torch::mv(turn, last->bias + (theta0 - centre) / scale));
  last->weight.copy_(torch::mm(turn, last->weight));
  theta0.zero_();
  torch::Tensor& dictionary = (*network)->dictionary();
  const torch::Tensor nodes = dictionary.slice(1, 0, K).clone();
  dictionary.select(1, K).add_(torch::mv(nodes, centre));
  dictionary.slice(1, 0, K).copy_(torch::mm(nodes, toTensor(from_codes)));
  (*network)->deviations().copy_(toTensor(deviation).view({K}));
}

}  // namespace nlg
