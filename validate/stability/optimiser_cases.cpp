// Fits from stiff places: rank-deficient Jacobians, extreme starts, extreme learning rates, vanished gradients.

#define EIGEN_USE_BLAS
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "runtime_eval/fit/direct.h"
#include "runtime_eval/support/finite.h"
#include "validate/stability/extreme_function.h"

namespace nlg {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(), kInfinity = std::numeric_limits<double>::infinity();

std::vector<Representation> allRepresentations() {
  std::vector<Representation> all;
  for (const char* name : kRepresentationNames) {
    Representation representation;
    findRepresentation(name, &representation);
    all.push_back(representation);
  }
  return all;
}

// Whether a fit kept its promises: a finite start gives a finite theta that is no worse; any other comes back as it was.
struct FitVerdict {
  bool finite = true, no_worse = true, within_budget = true;
  bool holds() const { return finite && no_worse && within_budget; }
};
FitVerdict judge(const Representation& representation, const WeightingFunction& function, const Theta& start,
                 const FitResult& fit, int budget) {
  FitVerdict verdict;
  verdict.within_budget = fit.steps <= budget;
  const double before = functionRmse(representation, function, start.data());
  if (!std::isfinite(before)) {
    // bit for bit: a NaN is not equal to itself
    const bool as_given = std::equal(start.begin(), start.end(), fit.theta.begin(),
                                     [](float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); });
    verdict.no_worse = as_given && fit.stop == FitStop::not_finite;
    return verdict;
  }
  verdict.finite = allFinite(fit.theta) && std::isfinite(fit.rmse);
  verdict.no_worse = functionRmse(representation, function, fit.theta.data()) <= before;
  return verdict;
}

// --- rank-deficient Jacobians -----------------------------------------------------------------------------------------------

// Products of the normal equations are summed in float over 1024 points, the errors of which add up like a random walk.
constexpr double kFloatSumRounding = 32 * 0x1p-24;

struct Spectrum {
  double condition = 0.0;  // largest over smallest eigenvalue, the smallest taken for no less than a rounding of the largest
  bool at_limit = false;   // that was so: the condition is at least this
  int rank = 0;            // eigenvalues that stand out of the rounding of float sums
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
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
  const double largest = values.maxCoeff();
  Spectrum spectrum;
  spectrum.size = hessian.count();
  spectrum.rank = static_cast<int>((values.array() > kFloatSumRounding * largest).count());
  spectrum.at_limit = values.minCoeff() < 0x1p-52 * largest;
  spectrum.condition = largest / std::max(values.minCoeff(), 0x1p-52 * largest);
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
  result.passes = spectrum.rank < spectrum.size && fit.rmse < before &&
                  judge(start.representation, function, start.theta, fit, kIterations).holds();
  result.measured =
      fmt::format("{}: J^T J has rank {} of {}, condition {}{:.1e}; RMSE {:.4f} -> {:.4f} in {} iterations, stop: {}",
                  representationName(start.representation), spectrum.rank, spectrum.size, spectrum.at_limit ? "at least " : "",
                  spectrum.condition, before, fit.rmse, fit.steps, fitStopName(fit.stop));
  result.figures = {{"condition", spectrum.condition}, {"rank", spectrum.rank},  {"parameters", spectrum.size},
                    {"rmse_before", before},           {"rmse_after", fit.rmse}, {"iterations", fit.steps}};
  return result;
}

// Half of both layers' units say nothing, and nothing hears them.
DeficientStart deadUnits() {
  const Representation network = Representation::tentMlp();
  Theta theta = randomTheta(network, 3);
  for (int unit = 0; unit < kHiddenCount; unit += 2) {
    for (int i = 0; i < 3; ++i) theta[ThetaLayout::w1 + 3 * unit + i] = 0.0f;
    theta[ThetaLayout::b1 + unit] = 0.0f;
    for (int row = 0; row < kHiddenCount; ++row) theta[ThetaLayout::w2 + kHiddenCount * row + unit] = 0.0f;
    theta[ThetaLayout::w3 + unit] = 0.0f;
  }
  return {network, functionBesideWall(5, 0.3), theta};
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

DeficientStart fewPoints() {
  const SampledFunction wall = functionBesideWall(7, 0.3);
  const SampledFunction few =
      sampleFunction([&](int p) { return wall.phi[p] / 255.0; }, [](int p) { return p % (kSupportPointCount / 20) == 7; });
  return {Representation::tentMlp(), few, randomTheta(Representation::tentMlp(), 5)};
}

// The nearest to duplicate points that a fixed pattern allows: all of them in one corner, a handful of cells of 9³ nodes.
DeficientStart crowdedPoints() {
  const Representation field = Representation::productField(9);
  const auto crowded = [](int p) {
    const LocalPoint& point = supportPattern().points[p];
    return point[0] > 0.6f && point[1] > 0.6f && point[2] > 0.6f;
  };
  return {field, sampleFunction([](int p) { return 4.0 * tent(supportPattern().points[p]); }, crowded), randomTheta(field, 6)};
}

StabilityCase deficientCase(const std::string& name, const std::function<DeficientStart()>& make, StabilityDepth depth) {
  return {"optimisers",
          "LM, " + name,
          "with a singular J^T J Levenberg-Marquardt still lowers the error, gives finite numbers and keeps to its iterations",
          depth,
          false,
          [make](const StabilityInputs&) { return measureDeficient(make()); }};
}

// --- extreme starts ---------------------------------------------------------------------------------------------------------

struct NamedStart {
  const char* name;
  double value;
  bool everywhere;  // or only in the first number, the rest at random
};
constexpr NamedStart kStarts[] = {{"zero", 0.0, true},     {"+1e3", 1e3, true},      {"-1e3", -1e3, true},
                                  {"+1e-42", 1e-42, true}, {"-1e-42", -1e-42, true}, {"one 1e30", 1e30, false},
                                  {"NaN", kNaN, true},     {"one NaN", kNaN, false}, {"one Inf", kInfinity, false}};

Theta startOf(const Representation& representation, const NamedStart& start) {
  Theta theta = randomTheta(representation, 8);
  if (start.everywhere) {
    std::fill(theta.begin(), theta.end(), static_cast<float>(start.value));
  } else {
    theta[0] = static_cast<float>(start.value);
  }
  return theta;
}

// Counts of fits, and what went wrong with which.
struct FitTally {
  int fits = 0, refused = 0, lowered = 0;
  std::string broken;

  void add(const std::string& what, const FitVerdict& verdict, const FitResult& fit, double before) {
    ++fits;
    refused += fit.stop == FitStop::not_finite;
    lowered += fit.rmse < before;
    if (!verdict.holds() && broken.size() < 200) broken += (broken.empty() ? "" : ", ") + what;
  }
  StabilityResult result(const std::string& steps) const {
    StabilityResult result;
    result.passes = broken.empty();
    result.measured = fmt::format("{} fits of {}: {} lowered the error, {} stopped as not finite, {}", fits, steps, lowered,
                                  refused, broken.empty() ? "none broke its promise" : "broken: " + broken);
    result.figures = {{"fits", fits}, {"lowered", lowered}, {"stopped_not_finite", refused}};
    return result;
  }
};

StabilityResult measureStarts(const StabilityInputs& inputs) {
  const int adam_steps = inputs.depth == StabilityDepth::brief ? 100 : 1000,
            lm_iterations = inputs.depth == StabilityDepth::brief ? 2 : 20;
  const SampledFunction wall = functionBesideWall(9, 0.3);
  FitTally tally;
  NormalEquationsKernel kernel;
  for (const Representation& representation : allRepresentations()) {
    const WeightingFunction function = decodeFunction(wall.view(), pointOrder(representation));
    for (const NamedStart& named : kStarts) {
      const Theta start = startOf(representation, named);
      const double before = functionRmse(representation, function, start.data());
      const std::string what = std::string(representationName(representation)) + " from " + named.name;
      AdamOptions adam;
      adam.steps = adam_steps;
      const FitResult by_adam = fitAdam(representation, function, start, adam);
      tally.add(what + " by Adam", judge(representation, function, start, by_adam, adam_steps), by_adam, before);
      LevenbergMarquardtOptions lm;
      lm.iterations = lm_iterations;
      const FitResult by_lm = fitLevenbergMarquardt(representation, function, start, lm, &kernel);
      tally.add(what + " by LM", judge(representation, function, start, by_lm, lm_iterations), by_lm, before);
    }
  }
  return tally.result(fmt::format("{} Adam steps or {} LM iterations", adam_steps, lm_iterations));
}

StabilityResult measureRates(const StabilityInputs& inputs) {
  const int steps = inputs.depth == StabilityDepth::brief ? 100 : 1000;
  const SampledFunction wall = functionBesideWall(10, 0.3);
  FitTally tally;
  for (const Representation& representation : allRepresentations()) {
    const WeightingFunction function = decodeFunction(wall.view(), pointOrder(representation));
    const Theta start = randomTheta(representation, 9);
    for (int decade = -5; decade <= 2; ++decade) {
      AdamOptions options;
      options.steps = steps;
      options.learning_rate = std::pow(10.0, decade);
      const FitResult fit = fitAdam(representation, function, start, options);
      tally.add(fmt::format("{} at 1e{}", representationName(representation), decade),
                judge(representation, function, start, fit, steps), fit, functionRmse(representation, function, start.data()));
    }
  }
  return tally.result(fmt::format("{} steps", steps));
}

// --- vanished gradients -----------------------------------------------------------------------------------------------------

Theta saturatedNetwork(const Representation& network, float bias) {
  Theta theta = randomTheta(network, 11);
  theta[network.shape().b3()] = bias;
  return theta;
}

Theta constantField(int resolution, float a, float b) {
  Theta theta(Representation::productField(resolution).thetaCount());
  for (size_t i = 0; i < theta.size(); i += 2) theta[i] = a, theta[i + 1] = b;
  return theta;
}

struct StuckStart {
  std::string name;
  Representation representation;
  Theta theta;
};

std::vector<StuckStart> stuckStarts() {
  std::vector<StuckStart> starts;
  for (const char* name : {"tent_mlp88", "tent_mlp44", "tent_mlp4"}) {
    Representation network;
    findRepresentation(name, &network);
    for (const float bias : {-90.0f, 90.0f})
      starts.push_back({fmt::format("{} at {}", name, bias), network, saturatedNetwork(network, bias)});
  }
  for (const int resolution : {3, 5}) {
    const Representation field = Representation::productField(resolution);
    const std::string name = representationName(field);
    starts.push_back({name + " below the clamp", field, constantField(resolution, -2.0f, 0.0f)});
    starts.push_back({name + " above the clamp", field, constantField(resolution, 3.0f, 0.0f)});
    starts.push_back({name + " with B at -90", field, constantField(resolution, 0.5f, -90.0f)});
    starts.push_back({name + " with B at 90", field, constantField(resolution, 0.5f, 90.0f)});
  }
  return starts;
}

StabilityResult measureStuck(const StabilityInputs& inputs) {
  const int adam_steps = inputs.depth == StabilityDepth::brief ? 200 : 1000;
  const SampledFunction wall = functionBesideWall(12, 0.3);
  NormalEquationsKernel kernel;
  FunctionChecker checker;
  Refiner refiner;
  int out = 0, reported = 0, silent = 0, refined_out = 0;
  double worst_refined = 0.0;
  const std::vector<StuckStart> starts = stuckStarts();
  for (const StuckStart& start : starts) {
    const WeightingFunction function = decodeFunction(wall.view(), pointOrder(start.representation));
    const double before = functionRmse(start.representation, function, start.theta.data());
    AdamOptions adam;
    adam.steps = adam_steps;
    const LevenbergMarquardtOptions lm;
    for (const FitResult& fit : {fitAdam(start.representation, function, start.theta, adam),
                                 fitLevenbergMarquardt(start.representation, function, start.theta, lm, &kernel)}) {
      // reported: the check that a bake makes of every theta counts it as failed
      const bool is_out = fit.rmse < 0.9 * before;
      const bool is_reported = !checker.check(start.representation, wall.view(), fit.theta.data(), {}).passes({});
      out += is_out;
      reported += !is_out && is_reported;
      silent += !is_out && !is_reported;
    }
    // as a bake goes on: from theta0 too
    RefinementOptions refinement;
    refinement.rounds = 1;
    const Theta theta0 = randomTheta(start.representation, 13);
    const RefinementResult refined = refiner.refine(start.representation, wall.view(), start.theta, theta0, refinement);
    refined_out += refined.check.rmse < 0.9 * before;
    worst_refined = std::max(worst_refined, refined.check.rmse);
  }
  StabilityResult result;
  result.passes = silent == 0 && refined_out == static_cast<int>(starts.size());
  result.measured = fmt::format(
      "{} fits: {} got out, {} stayed and fail the check, {} stayed unnoticed; refinement got {} of {} starts out, worst RMSE "
      "{:.4f}",
      2 * starts.size(), out, reported, silent, refined_out, starts.size(), worst_refined);
  result.figures = {{"fits", 2.0 * static_cast<double>(starts.size())},
                    {"got_out", out},
                    {"reported", reported},
                    {"unnoticed", silent},
                    {"refined_out", refined_out},
                    {"worst_rmse_refined", worst_refined}};
  return result;
}

// --- linear algebra and direct fits -----------------------------------------------------------------------------------------

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
    const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(hilbert, Eigen::EigenvaluesOnly).eigenvalues();
    largest_condition = std::max(largest_condition, values.maxCoeff() / std::max(values.minCoeff(), 0x1p-52 * values.maxCoeff()));
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
  result.passes = worst_residual <= 24 * 24 * 0x1p-53 && solved > 0 && refused > 0;
  result.measured = fmt::format(
      "Hilbert matrices of 4 to 24 rows, condition up to {:.1e}: {} solved with a relative residual of at most {:.1e}, {} "
      "refused",
      largest_condition, solved, worst_residual, refused);
  result.figures = {
      {"largest_condition", largest_condition}, {"solved", solved}, {"refused", refused}, {"relative_residual", worst_residual}};
  return result;
}

StabilityResult measureDirect(const StabilityInputs&) {
  DirectOptions options;
  options.adam_steps = 1600;
  options.levenberg_iterations = 4;
  options.restarts = 1;
  NormalEquationsKernel kernel;
  double worst = 0.0;
  bool finite = true;
  const SampledFunction wall = functionBesideWall(14, 0.3);
  for (const Representation& representation : {Representation::tentMlp(), Representation::productField(5)}) {
    const WeightingFunction function = decodeFunction(wall.view(), pointOrder(representation));
    const Theta broken(representation.thetaCount(), static_cast<float>(kNaN));
    const FitResult best = fitDirect(representation, function, broken, options, &kernel).best;
    finite = finite && allFinite(best.theta);
    worst = std::max(worst, best.rmse);
  }
  StabilityResult result;
  const double zero = rmseOfZero(wall);
  result.passes = finite && worst < 0.5 * zero;
  result.measured = fmt::format("tent_mlp and pf5: worst RMSE {:.4f}; answering 0: {:.4f}", worst, zero);
  result.figures = {{"worst_rmse", worst}, {"rmse_of_zero", zero}};
  return result;
}

}  // namespace

std::vector<StabilityCase> optimiserCases() {
  const auto brief = StabilityDepth::brief, full = StabilityDepth::full;
  return {
      deficientCase("dead units", deadUnits, brief),
      deficientCase("twin units", twinUnits, brief),
      deficientCase("fewer valid points than parameters", fewPoints, brief),
      deficientCase("all points in one corner", crowdedPoints, full),
      {"optimisers", "extreme starts",
       "from zero, +-1e3, denormals and 1e30 no fit ends worse than it began or not finite; a start of NaN or Inf comes back as "
       "given, "
       "reported as not_finite; no fit takes more steps than its budget",
       brief, false, measureStarts},
      {"optimisers", "Adam at learning rates from 1e-5 to 1e2",
       "whatever the rate, theta is finite, no worse than the start, and no more steps are taken than asked for", brief, false,
       measureRates},
      {"optimisers", "saturated sigmoids and clamped fields",
       "where the gradient has vanished a fit gets out (error down by a tenth) or its result fails the bake's check, and the "
       "bake's "
       "refinement, which tries theta0 too, gets out of every one",
       brief, false, measureStuck},
      {"optimisers", "direct optimisation from a theta0 of NaN",
       "the random starts still give a finite fit of less than half the error of answering 0", full, false, measureDirect},
      {"optimisers", "solver on nearly singular matrices",
       "every system is either solved to a residual of rounding size or refused", brief, false, measureSolver},
  };
}

}  // namespace nlg
