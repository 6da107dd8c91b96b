// Singular and nearly singular systems: Levenberg-Marquardt on rank-deficient Jacobians, and the solver it stands on.

#define EIGEN_USE_BLAS
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "runtime_eval/fit/levenberg_marquardt.h"
#include "validate/stability/extreme_function.h"
#include "validate/stability/fit_verdict.h"

namespace nlg {
namespace {

// Products of the normal equations are summed in float over 1024 points, the errors of which add up like a random walk.
constexpr double kFloatSumRounding = 32 * 0x1p-24;
constexpr double kDoubleRounding = 0x1p-52;

// Largest over smallest eigenvalue, the smallest taken for no less than a rounding of the largest.
double conditionOf(const Eigen::VectorXd& eigenvalues) {
  const double largest = eigenvalues.maxCoeff();
  return largest / std::max(eigenvalues.minCoeff(), kDoubleRounding * largest);
}

Eigen::VectorXd eigenvaluesOf(const Eigen::MatrixXd& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric, Eigen::EigenvaluesOnly).eigenvalues();
}

struct Spectrum {
  double condition = 0.0;
  bool at_limit = false;  // that was so: the condition is at least this
  int rank = 0;           // eigenvalues that stand out of the rounding of float sums
  int size = 0;
};

Spectrum spectrumOf(const Representation& representation, const WeightingFunction& function, const Theta& theta) {
  NormalEquationsKernel kernel;
  NormalEquations equations;
  kernel.compute(representation, function, theta.data(), &equations);
  const SymmetricBand& hessian = equations.hessian;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(hessian.count(), hessian.count());
  for (int row = 0; row < hessian.count(); ++row) {
    for (int column = std::max(0, row - hessian.bandwidth()); column <= row; ++column)
      matrix(row, column) = hessian.at(row, column);
  }
  const Eigen::VectorXd values = eigenvaluesOf(matrix);
  const double largest = values.maxCoeff();
  Spectrum spectrum;
  spectrum.size = hessian.count();
  spectrum.rank = static_cast<int>((values.array() > kFloatSumRounding * largest).count());
  spectrum.at_limit = values.minCoeff() < kDoubleRounding * largest;
  spectrum.condition = conditionOf(values);
  return spectrum;
}

struct DeficientStart {
  Representation representation;
  SampledFunction function;
  Theta theta;
};

StabilityResult measureDeficient(const DeficientStart& start) {
  constexpr int kIterations = 20;
  const WeightingFunction function = decodeFunction(start.function.view(), pointOrder(start.representation));
  const Spectrum spectrum = spectrumOf(start.representation, function, start.theta);
  NormalEquationsKernel kernel;
  LevenbergMarquardtOptions options;
  options.iterations = kIterations;
  const FitResult fit = fitLevenbergMarquardt(start.representation, function, start.theta, options, &kernel);
  const double before = functionRmse(start.representation, function, start.theta.data());
  StabilityResult result;
  result.holds = spectrum.rank < spectrum.size && fit.rmse < before &&
                 judge(start.representation, function, start.theta, fit, kIterations).holds();
  result.measured =
      fmt::format("{}: J^T J has rank {} of {}, condition {}{:.1e}; RMSE {:.4f} -> {:.4f} in {} iterations, stop: {}",
                  representationName(start.representation), spectrum.rank, spectrum.size, spectrum.at_limit ? "at least " : "",
                  spectrum.condition, before, fit.rmse, fit.steps, fitStopName(fit.stop));
  result.figures = {{"condition", spectrum.condition}, {"rank", spectrum.rank},  {"parameters", spectrum.size},
                    {"rmse_before", before},           {"rmse_after", fit.rmse}, {"iterations", fit.steps}};
  return result;
}

// Pairs of units that are the same: what one of them could learn the other one learns too.
DeficientStart twinUnits() {
  const Representation network = Representation::tentMlp();
  Theta theta = randomTheta(network, 4);
  for (int unit = 1; unit < kHiddenCount; unit += 2) {
    for (int i = 0; i < 3; ++i) theta[ThetaLayout::w1 + 3 * unit + i] = theta[ThetaLayout::w1 + 3 * (unit - 1) + i];
    theta[ThetaLayout::b1 + unit] = theta[ThetaLayout::b1 + unit - 1];
    for (int row = 0; row < kHiddenCount; ++row) {
      theta[ThetaLayout::w2 + kHiddenCount * row + unit] = theta[ThetaLayout::w2 + kHiddenCount * row + unit - 1];
    }
  }
  return {network, functionBesideWall(6, 0.3), theta};
}

// The nearest to duplicate points that a fixed pattern allows: all of them in one corner, a handful of cells of 9³ nodes.
DeficientStart crowdedPoints() {
  const Representation field = Representation::productField(9);
  const auto crowded = [](int p) {
    const LocalPoint& point = pointAt(p);
    return point[0] > 0.6f && point[1] > 0.6f && point[2] > 0.6f;
  };
  return {field, sampleFunction([](int p) { return 4.0 * tent(pointAt(p)); }, crowded), randomTheta(field, 6)};
}

StabilityCase deficientCase(const std::string& name, const std::function<DeficientStart()>& make, StabilityDepth depth) {
  return {"optimisers",
          "LM, " + name,
          "with a singular J^T J Levenberg-Marquardt still lowers the error, gives finite numbers and keeps to its iterations",
          depth,
          false,
          [make](const StabilityInputs&) { return measureDeficient(make()); }};
}

StabilityResult measureSolver(const StabilityInputs&) {
  double worst_residual = 0.0, largest_condition = 0.0;
  int solved = 0, refused = 0;
  for (int count = 4; count <= 24; count += 4) {
    Eigen::MatrixXd hilbert(count, count);
    SymmetricBand band(count, count - 1);
    for (int row = 0; row < count; ++row) {
      for (int column = 0; column < count; ++column) hilbert(row, column) = 1.0 / (row + column + 1);
      for (int column = 0; column <= row; ++column) band.at(row, column) = hilbert(row, column);
    }
    largest_condition = std::max(largest_condition, conditionOf(eigenvaluesOf(hilbert)));
    Eigen::VectorXd x = Eigen::VectorXd::Ones(count);
    if (!band.solve(x.data())) {
      ++refused;
      continue;
    }
    ++solved;
    const double residual = (hilbert * x - Eigen::VectorXd::Ones(count)).norm() / (hilbert.norm() * x.norm() + std::sqrt(count));
    worst_residual = std::max(worst_residual, residual);
  }
  StabilityResult result;
  // Cholesky is backward stable: a small multiple of the count times a rounding (Higham 2002, theorem 10.4)
  result.holds = worst_residual <= 24 * 24 * 0x1p-53 && solved > 0 && refused > 0;
  result.measured = fmt::format(
      "Hilbert matrices of 4 to 24 rows, condition up to {:.1e}: {} solved with a relative residual of at most {:.1e}, {} "
      "refused",
      largest_condition, solved, worst_residual, refused);
  result.figures = {
      {"largest_condition", largest_condition}, {"solved", solved}, {"refused", refused}, {"relative_residual", worst_residual}};
  return result;
}

}  // namespace

std::vector<StabilityCase> singularJacobianCases() {
  const auto brief = StabilityDepth::brief, full = StabilityDepth::full;
  return {
      deficientCase("twin units", twinUnits, brief),
      deficientCase("all points in one corner", crowdedPoints, full),
  };
}

std::vector<StabilityCase> singularMatrixCases() {
  return {{"optimisers", "solver on nearly singular matrices",
           "every system is either solved to a residual of rounding size or refused", StabilityDepth::brief, false,
           measureSolver}};
}

}  // namespace nlg
