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

}  // namespace

std::vector<StabilityCase> extremeFitCases() {
  return {
      {"optimisers", "extreme starts",
       "from zero, +-1e3, denormals and 1e30 no fit ends worse than it began or not finite; a start of NaN or Inf comes back as "
       "given, reported as not_finite; no fit takes more steps than its budget",
       StabilityDepth::brief, false, measureStarts},
      {"optimisers", "Adam at learning rates from 1e-5 to 1e2",
       "whatever the rate, theta is finite, no worse than the start, and no more steps are taken than asked for",
       StabilityDepth::brief, false, measureRates},
  };
}

}  // namespace nlg
