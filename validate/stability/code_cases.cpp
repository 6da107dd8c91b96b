// Codes: how near to a minimum the fits of bakes end, and how well their equations are conditioned.

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/fit/adam.h"
#include "runtime_eval/fit/code_fit.h"
#include "runtime_eval/numbers/finite.h"
#include "runtime_eval/numbers/random.h"
#include "validate/stability/extreme_function.h"

namespace nlg {
namespace {

// Fits that may take their time: their ends are minima to what the rounding of float sums hides.
constexpr int kIterations = 300;
constexpr double kProgress = 1e-9;
// As CodeFit damps: every number counts as if it did so much of what the strongest does.
constexpr double kLeastDiagonal = 1e-3;

struct NamedFunction {
  std::string name;
  SampledFunction sampled;
};

std::vector<NamedFunction> wallFunctions(int count) {
  std::vector<NamedFunction> functions;
  for (int i = 0; i < count; ++i) {
    const double distance = 0.05 + 0.7 * i / std::max(1, count - 1);
    functions.push_back(
        {fmt::format("wall {} at {:.2f}", 20 + i, distance), functionBesideWall(static_cast<uint64_t>(20 + i), distance)});
  }
  return functions;
}

std::vector<NamedFunction> stiffFunctions() {
  std::vector<NamedFunction> functions = wallFunctions(4);
  const auto bare = [](int p) { return static_cast<double>(tent(pointAt(p))); };
  functions.push_back({"dark everywhere", sampleFunction([](int) { return 0.0; })});
  functions.push_back({"lit everywhere", sampleFunction(bare)});
  functions.push_back({"one valid point", sampleFunction(bare, [](int p) { return p == kOctantPointCount / 2; })});
  functions.push_back({"all points in one corner", sampleFunction(bare, [](int p) {
                         return *std::min_element(pointAt(p).begin(), pointAt(p).end()) > 0.6f;
                       })});
  functions.push_back({"every second point dark",
                       sampleFunction([&](int p) { return mixSeed(5, static_cast<uint64_t>(p)) & 1 ? bare(p) : 0.0; })});
  return functions;
}

std::vector<const NamedGenerator*> codesOf(const StabilityInputs& inputs) {
  std::vector<const NamedGenerator*> codes;
  for (const NamedGenerator& named : inputs.generators) {
    if (named.generator.representation().isCode()) codes.push_back(&named);
  }
  return codes;
}

Theta networkCode(const Generator& generator, const StoredFunction& stored) {
  GeneratorScratch scratch(generator);
  Theta z(static_cast<size_t>(generator.representation().thetaCount()));
  generator.generate(&stored, 1, z.data(), &scratch);
  return z;
}

// Fits as bakes have them: few steps, of active points.
void measureBakedFits(const StabilityInputs& inputs, StabilityFigures* figures) {
  double worst_zero = 0.0, worst_network = 0.0, mean_zero = 0.0, mean_network = 0.0;
  int count = 0;
  for (const NamedGenerator* named : codesOf(inputs)) {
    const Representation& code = named->generator.representation();
    CodeFit fit;
    for (const NamedFunction& one : wallFunctions(inputs.is_short ? 4 : 24)) {
      const WeightingFunction function = decodeFunction(one.sampled.view(), pointOrder(code), CheckOptions().loss());
      const auto rmseFrom = [&](Theta z, const CodeFitOptions& options) {
        return fit.iterate(code, function, options, code.code_count, z.data()).rmse;
      };
      const Theta zero(static_cast<size_t>(code.code_count), 0.0f), network = networkCode(named->generator, one.sampled.view());
      // the minimum to compare with: a long fit over all points, the better of both starts
      const CodeFitOptions lengthy{.iterations = kIterations, .progress_tolerance = kProgress, .all_points = true};
      const double least = std::min(rmseFrom(zero, lengthy), rmseFrom(network, lengthy));
      const double from_zero = rmseFrom(zero, {}) / least, from_network = rmseFrom(network, {}) / least;
      worst_zero = std::max(worst_zero, from_zero);
      worst_network = std::max(worst_network, from_network);
      mean_zero += from_zero;
      mean_network += from_network;
      ++count;
    }
  }
  // shown without a bound; only the start that bakes have must hold
  figures->show("mean_from_zero_over_a_minimum", mean_zero / count);
  figures->show("mean_from_the_network_over_a_minimum", mean_network / count);
  figures->show("worst_from_zero_over_a_minimum", worst_zero);
  figures->atMost("worst_from_the_network_over_a_minimum", worst_network, kBestKnownFactor);
}

double conditionOf(const Eigen::MatrixXd& matrix) {
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
  // the smallest eigenvalue is taken for no less than a rounding of the largest
  return values.maxCoeff() / std::max(values.minCoeff(), 0x1p-52 * values.maxCoeff());
}

void measureConditions(const StabilityInputs& inputs, StabilityFigures* figures) {
  double bare = 0.0, with_prior = 0.0, with_damping = 0.0;
  std::string worst;
  // the worst over all codes and stiff functions
  for (const NamedGenerator* named : codesOf(inputs)) {
    const Representation& code = named->generator.representation();
    const int K = code.code_count;
    CodeFit fit;
    for (const NamedFunction& one : stiffFunctions()) {
      const std::string what = named->name + ", " + one.name;
      const WeightingFunction function = decodeFunction(one.sampled.view(), pointOrder(code), CheckOptions().loss());
      Theta z = networkCode(named->generator, one.sampled.view());
      const double before = functionRmse(code, function, z.data());
      const CodeFitOptions options;
      const FitResult end = fit.iterate(code, function, options, K, z.data());
      // what holds of every fit: finite, no worse than its start, no more steps than allowed
      figures->require(allFinite(z) && std::isfinite(end.rmse) && end.rmse <= before, what + " got worse");
      figures->require(end.steps <= options.iterations, what + " took more steps than it may");
      // condition of the equations alone, with the prior, and with the first damping
      const auto equationsOf = [&](double prior) {
        CodeFitOptions with = options;
        with.prior = prior;
        CodeEquations equations;
        fit.equationsAt(code, function, with, z.data(), &equations);
        return Eigen::MatrixXd(Eigen::Map<const Eigen::MatrixXf>(equations.matrix.data(), K, K).cast<double>());
      };
      const Eigen::MatrixXd alone = equationsOf(0.0), held = equationsOf(options.prior);
      Eigen::MatrixXd damped = held;
      damped.diagonal() += options.damping * alone.diagonal().cwiseMax(kLeastDiagonal * alone.diagonal().maxCoeff());
      const double condition = conditionOf(held);
      if (condition > with_prior) worst = what;
      bare = std::max(bare, conditionOf(alone));
      with_prior = std::max(with_prior, condition);
      with_damping = std::max(with_damping, conditionOf(damped));
      // float must be enough: Cholesky of the prior's equations
      CodeEquations equations;
      fit.equationsAt(code, function, options, z.data(), &equations);
      figures->require(equations.factor(), what + ": its equations cannot be solved in float");
    }
  }
  figures->show("condition_alone_at_most", bare);
  // a float has 24 bits: beyond, an equation would be of rounding alone
  figures->atMost("condition_with_the_prior_at_most", with_prior, 0x1p24);
  figures->show("condition_with_the_first_damping_at_most", with_damping);
  if (!worst.empty()) figures->remark("worst: " + worst);
}

}  // namespace

std::vector<StabilityCase> codeCases() {
  return {
      {"codes", "fits as bakes have them",
       "a bake's fit from the network's code ends at most at 1.5 times the error of a minimum", measureBakedFits, true},
      {"codes", "condition of their equations",
       "of walls, of functions that are dark or lit everywhere, of one valid point, of points in one corner and of noise the "
       "equations with "
       "their prior are solvable in float, and no fit ends worse than it began",
       measureConditions, true},
  };
}

}  // namespace nlg
