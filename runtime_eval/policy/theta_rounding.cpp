#include "runtime_eval/policy/theta_rounding.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/fit/last_layer.h"
#include "runtime_eval/policy/code_rounding.h"
#include "runtime_eval/policy/compensated_rounding.h"

namespace nlg {
namespace {

// Roundings to bytes are tried one after another, until the error is at most kRoundingExcess times what it was, or has grown by no
// more than kRoundingAdds. In the first kRoundingWays each number is rounded for itself; in those of kCompensatedWays numbers make up
// for each other. Few theta need a second one (docs/lab/training.md).
constexpr int kRoundingWays = 4;
struct CompensatedWay {
  double share;  // of the steps
  double damping;
  int first_batch;
};
constexpr CompensatedWay kCompensatedWays[] = {{0.976, 0.03, 0}, {0.929, 0.1, 3}, {0.953, 0.01, 6}, {0.882, 0.03, 9}};
constexpr double kRoundingExcess = 1.02, kRoundingAdds = 5e-5;

// Fits drive the logits of product fields to any size where a larger one changes nothing. The largest half stands for all beyond it;
// what that does to the function, the check finds.
Theta limited(Theta theta) {
  for (float& number : theta) number = std::clamp(number, -kMaxHalf, kMaxHalf);
  return theta;
}

void roundLimited(const Representation& representation, ThetaPrecision precision, Theta* theta) {
  *theta = limited(std::move(*theta));
  roundTheta(representation, precision, theta->data());
}

}  // namespace

ThetaRounding::ThetaRounding(const PolicyOptions& options) {
  if (options.theta_precision != ThetaPrecision::int8) return;
  compensated_ = std::make_unique<CompensatedRounding>();
  code_ = std::make_unique<CodeRounding>(options);
}

ThetaRounding::~ThetaRounding() = default;

RoundedTheta ThetaRounding::round(const Representation& representation, const StoredFunction& function,
                                  const RoundedTheta& present, const CheckOptions& check) {
  // product fields stay in float16
  if (compensated_ == nullptr || representation.isField()) return roundToHalves(representation, function, present.theta, check);
  if (representation.isCode()) return code_->round(representation, function, present, check);
  return roundToBytes(representation, function, present, check);
}

RoundedTheta ThetaRounding::roundToHalves(const Representation& representation, const StoredFunction& function,
                                          const Theta& theta, const CheckOptions& check) {
  RoundedTheta rounded{theta, {}};
  roundLimited(representation, ThetaPrecision::float16, &rounded.theta);
  rounded.check = checker_.check(representation, function, rounded.theta.data(), check);
  return rounded;
}

// The last layer makes up for what the hidden ones lose; solved before it is rounded itself, it may still be the worse one.
RoundedTheta ThetaRounding::roundToBytes(const Representation& network, const StoredFunction& function,
                                         const RoundedTheta& present, const CheckOptions& check) {
  // where a theta passes, its blend RMSE alone is what counts
  const auto badness = [&](const FunctionCheck& of) {
    return of.passes(check) ? of.blend_rmse / check.tau_blend : of.trouble(check);
  };
  const double before = badness(present.check),
               enough = std::max(kRoundingExcess * before, before + kRoundingAdds / check.tau_blend);
  RoundedTheta best;
  const auto isDone = [&] { return !best.theta.empty() && badness(best.check) <= enough; };
  const auto offer = [&](Theta theta) {
    roundLimited(network, ThetaPrecision::int8, &theta);
    const FunctionCheck found = checker_.check(network, function, theta.data(), check);
    if (best.theta.empty() || badness(found) < badness(best.check)) best = {std::move(theta), found};
  };
  const Theta start = limited(present.theta);  // scaled units of larger numbers would leave the range of floats
  const WeightingFunction values = decodeFunction(function, pointOrder(network), check.loss());
  const auto offerSolvedAndNot = [&](Theta theta) {
    Theta solved = theta;
    if (solveLastLayer(network, values, solved.data())) offer(std::move(solved));
    if (!isDone()) offer(std::move(theta));
  };
  const int most = enoughThetaSteps(network.shape());
  for (int way = 0; way < kRoundingWays && !isDone(); ++way) {
    Theta theta = start;
    roundHiddenLayers(network, theta.data(), {most - 2 * way, most});
    offerSolvedAndNot(std::move(theta));
  }
  if (isDone()) return best;
  for (const CompensatedWay& way : kCompensatedWays) {
    Theta theta = start;
    const auto steps = static_cast<int>(std::lround(way.share * most));
    const Compensation compensation{{steps, steps}, way.damping, way.first_batch};
    if (isDone() || !compensated_->round(network, values, compensation, theta.data())) continue;
    offerSolvedAndNot(std::move(theta));
  }
  return best;
}

}  // namespace nlg
