// Fits from extreme starts and at extreme learning rates, of every representation.

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "runtime_eval/fit/adam.h"
#include "runtime_eval/fit/levenberg_marquardt.h"
#include "validate/stability/extreme_function.h"
#include "validate/stability/fit_verdict.h"

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

struct NamedStart {
  const char* name;
  double value;
  bool everywhere;  // or only in the first number, the rest at random
  // where the gradient is 0 for good: sigmoids at the output of networks at their ends, fields outside their clamp
  bool saturates_sigmoid = false, saturates_field = false;
};
constexpr NamedStart kStarts[] = {{"zero", 0.0, true},
                                  {"+1e3", 1e3, true, true, true},
                                  {"-1e3", -1e3, true, true, true},
                                  {"+1e-42", 1e-42, true},
                                  {"-1e-42", -1e-42, true, false, true},
                                  {"one 1e30", 1e30, false, true, false},
                                  {"NaN", kNaN, true},
                                  {"one NaN", kNaN, false},
                                  {"one Inf", kInfinity, false}};

bool saturates(const Representation& representation, const NamedStart& start) {
  if (representation.isField()) return start.saturates_field;
  return start.saturates_sigmoid && representation.shape().output == OutputFunction::sigmoid;
}

// The lowest error that a network's last bias alone gives, all else as in the start; of a grid, so at least the true one.
double bestByLastBias(const Representation& network, const WeightingFunction& function, Theta theta) {
  double best = kInfinity;
  for (int i = -32; i <= 32; ++i) {
    theta[network.shape().b3()] = static_cast<float>(i / 16.0);
    best = std::min(best, functionRmse(network, function, theta.data()));
  }
  return best;
}

// What the better of Adam and LM must come down to from a finite start; where nothing saturates there is a way down.
double mustReach(const Representation& representation, const WeightingFunction& function, const NamedStart& named,
                 const Theta& start, double before) {
  if (saturates(representation, named)) return before;
  // all units of a layer alike, and they stay so: the last bias is all that is left to move
  const bool units_alike = !representation.isField() && named.everywhere && std::fabs(named.value) < 1e-30;
  return units_alike ? 1.01 * bestByLastBias(representation, function, start) : 0.5 * before;
}

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
    require(verdict.holds(), what);
  }
  void require(bool holds, const std::string& what) {
    if (!holds && broken.size() < 200) broken += (broken.empty() ? "" : ", ") + what;
  }
  StabilityResult result(const std::string& steps) const {
    StabilityResult result;
    result.holds = broken.empty();
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
  FunctionChecker checker;
  int improved = 0, stuck = 0;
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
      if (!std::isfinite(before)) continue;
      const FitResult& better = by_adam.rmse < by_lm.rmse ? by_adam : by_lm;
      tally.require(better.rmse <= mustReach(representation, function, named, start, before), what + " by neither");
      // stuck: as bad as before, which a bake must notice
      const bool is_stuck = better.rmse > 0.9 * before;
      stuck += is_stuck, improved += !is_stuck;
      tally.require(!is_stuck || !checker.check(representation, wall.view(), better.theta.data(), {}).passes({}),
                    what + ", stuck unnoticed");
    }
  }
  StabilityResult result = tally.result(fmt::format("{} Adam steps or {} LM iterations", adam_steps, lm_iterations));
  result.measured += fmt::format("; of {} finite starts {} left behind, {} stuck where sigmoids or clamps saturate",
                                 improved + stuck, improved, stuck);
  result.figures["starts_left"] = improved;
  result.figures["starts_stuck"] = stuck;
  return result;
}

StabilityResult measureRates(const StabilityInputs& inputs) {
  const int steps = inputs.depth == StabilityDepth::brief ? 100 : 1000;
  const SampledFunction wall = functionBesideWall(10, 0.3);
  FitTally tally;
  double least = kInfinity;
  for (const Representation& representation : allRepresentations()) {
    const WeightingFunction function = decodeFunction(wall.view(), pointOrder(representation));
    const Theta start = randomTheta(representation, 9);
    const double before = functionRmse(representation, function, start.data());
    double best = before;
    for (int decade = -5; decade <= 2; ++decade) {
      AdamOptions options;
      options.steps = steps;
      options.learning_rate = std::pow(10.0, decade);
      const FitResult fit = fitAdam(representation, function, start, options);
      const std::string what = fmt::format("{} at 1e{}", representationName(representation), decade);
      tally.add(what, judge(representation, function, start, fit, steps), fit, before);
      const bool is_sane = decade >= -4 && decade <= -2;
      tally.require(!is_sane || fit.rmse < before, what + ", not lowered");
      best = std::min(best, fit.rmse);
    }
    tally.require(best <= 0.5 * before, representationName(representation) + std::string(" at no rate"));
    least = std::min(least, before / best);
  }
  StabilityResult result = tally.result(fmt::format("{} steps", steps));
  result.measured += fmt::format("; at its best rate every representation divides its error by {:.1f} or more", least);
  result.figures["least_division"] = least;
  return result;
}

}  // namespace

std::vector<StabilityCase> extremeFitCases() {
  return {
      {"optimisers", "extreme starts",
       "from zero, +-1e3, denormals and 1e30 no fit ends worse than it began or not finite; a start of NaN or Inf comes back as "
       "given, reported as not_finite; no fit takes more steps than its budget; where no sigmoid or clamp is saturated, Adam "
       "or LM halves the error (all units alike: reaches what the last bias can); what is stuck fails the bake's check",
       StabilityDepth::brief, false, measureStarts},
      {"optimisers", "Adam at learning rates from 1e-5 to 1e2",
       "whatever the rate, theta is finite, no worse than the start, and no more steps are taken than asked for; rates from "
       "1e-4 to 1e-2 lower the error, and the best rate halves it",
       StabilityDepth::brief, false, measureRates},
  };
}

}  // namespace nlg
