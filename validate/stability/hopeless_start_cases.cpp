// Fits from where no gradient leads on: saturated sigmoids and clamped fields.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "runtime_eval/fit/refinement.h"
#include "validate/stability/extreme_function.h"

namespace nlg {
namespace {

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
  result.holds = silent == 0 && refined_out == static_cast<int>(starts.size());
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

}  // namespace

std::vector<StabilityCase> hopelessStartCases() {
  return {
      {"optimisers", "saturated sigmoids and clamped fields",
       "where the gradient has vanished a fit gets out (error down by a tenth) or its result fails the bake's check, and the "
       "bake's refinement, which tries theta0 too, gets out of every one",
       StabilityDepth::brief, false, measureStuck},
  };
}

}  // namespace nlg
