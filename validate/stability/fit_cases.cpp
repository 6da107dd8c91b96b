// Fits from extreme starts and at extreme learning rates, of every representation, and where J^T J is singular.

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/numbers/finite.h"
#include "runtime_eval/policy/refinement.h"
#include "validate/stability/extreme_function.h"

namespace nlg {
namespace {

// All fits here minimise the loss of a bake, and their errors are blend RMSEs.
WeightingFunction decoded(const SampledFunction& sampled, const Representation& representation) {
  return decodeFunction(sampled.view(), pointOrder(representation), CheckOptions().loss());
}

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(), kInfinity = std::numeric_limits<double>::infinity();

// Networks and product fields by their names. Codes are nothing without a dictionary: those of the weights.
std::vector<Representation> allRepresentations(const StabilityInputs& inputs, StabilityFigures* figures) {
  std::vector<Representation> all;
  for (const char* name : kRepresentationNames) {
    Representation representation;
    findRepresentation(name, &representation);
    if (!representation.isCode()) all.push_back(representation);
  }
  const size_t without_codes = all.size();
  for (const NamedGenerator& named : inputs.generators) {
    if (named.generator.representation().isCode()) all.push_back(named.generator.representation());
  }
  if (all.size() == without_codes) figures->remark("codes are left out: no weights of any are given");
  return all;
}

// Names the fit where it broke what every fit promises: a finite start gives a finite theta that is no worse, any other is refused,
// and no fit takes more steps than it may.
void judge(const std::string& what, const Representation& representation, const WeightingFunction& function, const Theta& start,
           const FitResult& fit, int budget, StabilityFigures* figures) {
  const double before = functionRmse(representation, function, start.data());
  figures->require(fit.steps <= budget, what + " took more steps than it may");
  if (!std::isfinite(before)) return figures->require(fit.stop == FitStop::not_finite, what + " is not refused");
  const bool is_finite = allFinite(fit.theta) && std::isfinite(fit.rmse);
  figures->require(is_finite && functionRmse(representation, function, fit.theta.data()) <= before, what + " got worse");
}

struct Start {
  std::string name;
  Theta theta;
  bool saturated = false;    // a sigmoid at its end or a clamp leaves no gradient at all
  bool units_alike = false;  // all units of a layer, and they stay so: the last bias is all that is left to move
};

std::vector<Start> startsOf(const Representation& representation) {
  const bool is_field = representation.isField();
  const bool is_network = representation.isNetwork();
  const bool has_sigmoid = representation.isCode() || (is_network && representation.shape().output == OutputFunction::sigmoid);
  const auto filled = [&](double value) { return Theta(representation.thetaCount(), static_cast<float>(value)); };
  const auto with = [&](int place, double value) {
    Theta theta = randomTheta(representation, 8);
    theta[place] = static_cast<float>(value);
    return theta;
  };
  // all numbers alike, subnormal, huge, or not finite
  std::vector<Start> starts = {{"zero", filled(0.0), false, is_network},
                               {"+1e3", filled(1e3), is_field || has_sigmoid},
                               {"-1e3", filled(-1e3), is_field || has_sigmoid},
                               {"+1e-42", filled(1e-42), false, is_network},
                               {"-1e-42", filled(-1e-42), is_field, is_network},
                               {"one 1e30", with(0, 1e30), has_sigmoid},
                               {"NaN", filled(kNaN)},
                               {"one NaN", with(0, kNaN)},
                               {"one Inf", with(0, kInfinity)}};
  // sigmoids at either end, where their slope is 0 in float
  if (is_network && has_sigmoid) {
    for (const float bias : {-90.0f, 90.0f})
      starts.push_back({fmt::format("last bias {}", bias), with(representation.shape().b3(), bias), true});
  }
  if (is_field) {
    // A below and above its clamp; the sigmoid of B at its ends
    for (const auto& [a, b] : {std::pair{-2.0f, 0.0f}, {3.0f, 0.0f}, {0.5f, -90.0f}, {0.5f, 90.0f}}) {
      Theta theta = filled(a);
      for (size_t i = 1; i < theta.size(); i += 2) theta[i] = b;
      starts.push_back({fmt::format("A = {}, B = {}", a, b), std::move(theta), true});
    }
  }
  return starts;
}

// What the better of Adam and LM must come down to from a finite start; where nothing saturates there is a way down.
double mustReach(const Representation& representation, const WeightingFunction& function, const Start& start, double before) {
  if (start.saturated) return before;
  if (!start.units_alike) return 0.5 * before;
  // the lowest error that the last bias alone gives; of a grid, so at least the true one
  double best = kInfinity;
  Theta theta = start.theta;
  for (int i = -32; i <= 32; ++i) {
    theta[representation.shape().b3()] = static_cast<float>(i / 16.0);
    best = std::min(best, functionRmse(representation, function, theta.data()));
  }
  return 1.01 * best;
}

void measureStarts(const StabilityInputs& inputs, StabilityFigures* figures) {
  constexpr int kRefinedCount = 250;  // refinements of larger representations take minutes
  AdamOptions adam;
  adam.steps = inputs.isBrief() ? 250 : 1000;
  LevenbergMarquardtOptions lm;
  lm.iterations = inputs.isBrief() ? 5 : 20;
  RefinementOptions refinement;
  refinement.refine_rounds = 1;
  // one function beside a wall, so that starts alone differ
  const SampledFunction wall = functionBesideWall(9, 0.3);
  NormalEquationsKernel kernel;
  FunctionChecker checker;
  Refiner refiner;
  int left = 0, stuck = 0, refused = 0, refined = 0;
  double worst_refined = 0.0;
  for (const Representation& representation : allRepresentations(inputs, figures)) {
    const WeightingFunction function = decoded(wall, representation);
    for (const Start& start : startsOf(representation)) {
      const double before = functionRmse(representation, function, start.theta.data());
      const std::string what = std::string(representationName(representation)) + " from " + start.name;
      // by both fits that a bake has
      const FitResult by_adam = fitAdam(representation, function, start.theta, adam);
      const FitResult by_lm = fitLevenbergMarquardt(representation, function, start.theta, lm, &kernel);
      judge(what + " by Adam", representation, function, start.theta, by_adam, adam.steps, figures);
      judge(what + " by LM", representation, function, start.theta, by_lm, lm.iterations, figures);
      // a start that is not finite has no error to lower
      if (!std::isfinite(before)) {
        ++refused;
        continue;
      }
      const FitResult& better = by_adam.rmse < by_lm.rmse ? by_adam : by_lm;
      figures->require(better.rmse <= mustReach(representation, function, start, before), what + " is not lowered enough");
      // as bad as before, which a bake must notice
      const bool is_stuck = better.rmse > 0.9 * before;
      const bool passes = checker.check(representation, wall.view(), better.theta.data(), {}).passes({});
      figures->require(!is_stuck || !passes, what + " is stuck and passes the check");
      stuck += is_stuck, left += !is_stuck;
      if (!start.saturated || representation.thetaCount() > kRefinedCount) continue;
      // as a bake goes on: from theta0 too
      const double rmse =
          refiner.refine(representation, wall.view(), start.theta, randomTheta(representation, 13), {}, refinement)
              .check.blend_rmse;
      figures->require(rmse < 0.9 * before, what + " is not left by the refinement");
      worst_refined = std::max(worst_refined, rmse);
      ++refined;
    }
  }
  figures->show("starts_left_behind", left);
  figures->show("starts_where_fits_are_stuck", stuck);
  figures->show("starts_refused_as_not_finite", refused);
  figures->show("saturated_starts_refined", refined);
  figures->show("worst_rmse_refined", worst_refined);
}

void measureRates(const StabilityInputs& inputs, StabilityFigures* figures) {
  AdamOptions options;
  options.steps = inputs.isBrief() ? 100 : 1000;
  const SampledFunction wall = functionBesideWall(10, 0.3);
  double least = kInfinity;
  for (const Representation& representation : allRepresentations(inputs, figures)) {
    const WeightingFunction function = decoded(wall, representation);
    const Theta start = randomTheta(representation, 9);
    const double before = functionRmse(representation, function, start.data());
    double best = before;
    for (int decade = -5; decade <= 2; ++decade) {
      // codes count in steps
      options.learning_rate = (representation.isCode() ? 100.0 : 1.0) * std::pow(10.0, decade);
      const FitResult fit = fitAdam(representation, function, start, options);
      const std::string what = fmt::format("{} at 1e{}", representationName(representation), decade);
      judge(what, representation, function, start, fit, options.steps, figures);
      figures->require(decade < -4 || decade > -2 || fit.rmse < before, what + " is not lowered");
      best = std::min(best, fit.rmse);
    }
    least = std::min(least, before / best);
  }
  figures->atLeast("least_division_of_the_error_at_the_best_rate", least, 2.0);
}

// --- singular J^T J ---------------------------------------------------------------------------------------------------------

// Products of the normal equations are summed in float over 1024 points, the errors of which add up like a random walk.
constexpr double kFloatSumRounding = 32 * 0x1p-24;
constexpr int kIterations = 20;

// Eigenvalues of J^T J, rising.
Eigen::VectorXd eigenvaluesAt(const Representation& representation, const WeightingFunction& function, const Theta& theta) {
  NormalEquationsKernel kernel;
  NormalEquations equations;
  kernel.compute(representation, function, theta.data(), &equations);
  const SymmetricBand& hessian = equations.hessian;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(hessian.count(), hessian.count());
  for (int row = 0; row < hessian.count(); ++row) {
    for (int column = std::max(0, row - hessian.bandwidth()); column <= row; ++column)
      matrix(row, column) = hessian.at(row, column);
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
}

void measureDeficient(const Representation& representation, const SampledFunction& sampled, const Theta& theta,
                      StabilityFigures* figures) {
  const WeightingFunction function = decoded(sampled, representation);
  const Eigen::VectorXd eigenvalues = eigenvaluesAt(representation, function, theta);
  const double largest = eigenvalues.maxCoeff();
  NormalEquationsKernel kernel;
  LevenbergMarquardtOptions options;
  options.iterations = kIterations;
  const FitResult fit = fitLevenbergMarquardt(representation, function, theta, options, &kernel);
  figures->show("parameters", static_cast<double>(theta.size()));
  // of eigenvalues, those that stand out of the rounding of float sums
  figures->atMost("rank", static_cast<double>((eigenvalues.array() > kFloatSumRounding * largest).count()),
                  static_cast<double>(theta.size() - 1));
  // the smallest eigenvalue is taken for no less than a rounding of the largest
  figures->show("condition_at_least", largest / std::max(eigenvalues.minCoeff(), 0x1p-52 * largest));
  const double before = functionRmse(representation, function, theta.data());
  judge("the fit", representation, function, theta, fit, kIterations, figures);
  figures->show("rmse_before", before);
  figures->show("rmse_after", fit.rmse);
  figures->require(fit.rmse < before, "the error is not lowered");
  figures->show("iterations", fit.steps);
  figures->remark(std::string("stop: ") + fitStopName(fit.stop));
}

// Pairs of units that are the same: what one of them could learn the other one learns too.
void measureTwinUnits(const StabilityInputs&, StabilityFigures* figures) {
  const Representation network = Representation::tentMlp();
  Theta theta = randomTheta(network, 4);
  for (int unit = 1; unit < kHiddenCount; unit += 2) {
    for (int i = 0; i < 3; ++i) theta[ThetaLayout::w1 + 3 * unit + i] = theta[ThetaLayout::w1 + 3 * (unit - 1) + i];
    theta[ThetaLayout::b1 + unit] = theta[ThetaLayout::b1 + unit - 1];
    for (int row = 0; row < kHiddenCount; ++row) {
      theta[ThetaLayout::w2 + kHiddenCount * row + unit] = theta[ThetaLayout::w2 + kHiddenCount * row + unit - 1];
    }
  }
  measureDeficient(network, functionBesideWall(6, 0.3), theta, figures);
}

// The nearest to duplicate points that a fixed pattern allows: all of them in one corner, a handful of cells of 9³ nodes.
void measureCrowdedPoints(const StabilityInputs&, StabilityFigures* figures) {
  const Representation field = Representation::productField(9);
  const auto in_corner = [](int p) { return *std::min_element(pointAt(p).begin(), pointAt(p).end()) > 0.6f; };
  measureDeficient(field, sampleFunction([](int p) { return 4.0 * tent(pointAt(p)); }, in_corner), randomTheta(field, 6),
                   figures);
}

}  // namespace

std::vector<StabilityCase> fitCases() {
  const std::string singular =
      "with a singular J^T J Levenberg-Marquardt still lowers the error, gives finite numbers and keeps to its iterations";
  return {
      {"optimisers", "LM, twin units", singular, StabilityDepth::brief, false, measureTwinUnits},
      {"optimisers", "LM, all points in one corner", singular, StabilityDepth::full, false, measureCrowdedPoints},
      {"optimisers", "extreme starts",
       "from zero, +-1e3, denormals, 1e30, saturated sigmoids and clamped fields no fit ends worse than it began or not finite; "
       "a "
       "start of NaN or Inf is refused as not finite; no fit takes more steps than its budget; where nothing "
       "is "
       "saturated, Adam or LM halves the error (all units alike: reaches what the last bias can); what is stuck fails the bake's "
       "check, and the bake's refinement, which tries theta0 too, gets out of it",
       StabilityDepth::brief, false, measureStarts},
      {"optimisers", "Adam at learning rates from 1e-5 to 1e2",
       "whatever the rate, theta is finite, no worse than the start, and no more steps are taken than asked for; rates from "
       "1e-4 to 1e-2 lower the error, and the best rate halves it; codes, which count in steps, take a hundred times the rates",
       StabilityDepth::brief, false, measureRates},
  };
}

}  // namespace nlg
