#include "validate/stability/extreme_function.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "runtime_eval/numbers/finite.h"
#include "runtime_eval/numbers/random.h"
#include "validate/generators/best_known.h"

namespace nlg {
namespace {

// Sigmoids come near their ends but never to them, and a fit near its minimum.
constexpr double kConstantFactor = 1.01;
// Sums of another kernel: the same theta may differ in the last digits.
constexpr double kOtherKernel = 1.0 + 1e-6;

// Sums over points of squared errors of c times a shape, for every c.
struct ConstantSums {
  double shape_shape = 0.0, shape_phi = 0.0, phi_phi = 0.0;
  int count = 0;

  void add(double shape, double phi) {
    shape_shape += shape * shape;
    shape_phi += shape * phi;
    phi_phi += phi * phi;
    ++count;
  }
  double best() const { return shape_shape > 0.0 ? shape_phi / shape_shape : 0.0; }
  double rmse(double c) const {
    return count > 0 ? std::sqrt(std::max(0.0, phi_phi - 2.0 * c * shape_phi + c * c * shape_shape) / count) : 0.0;
  }
};

// What the check finds of c, of c tent(x) where the representation has the tent, for the c of the lowest blend RMSE that it can output.
FunctionCheck checkOfConstant(const Representation& representation, const StoredFunction& stored, const CheckOptions& check) {
  const LossWeights weights(check.loss());
  ConstantSums alike, blend;
  for (int p = 0; p < kSupportPointCount; ++p) {
    if (!stored.isValid(p)) continue;
    const float bare = tent(pointAt(p));
    const double root = weights.root(stored.phi[p], bare, stored.blendSum(p));
    const double shape = representation.tentFactor() ? bare : 1.0, phi = stored.phi[p] / 255.0;
    alike.add(shape, phi);
    blend.add(root * shape, root * phi);
  }
  const bool is_limited = !representation.isNetwork() || representation.shape().output == OutputFunction::sigmoid;
  const double c = is_limited ? std::min(blend.best(), 1.0) : blend.best();
  FunctionCheck found;
  found.rmse = alike.rmse(c);
  found.blend_rmse = blend.rmse(c);
  return found;
}

// The lowest blend RMSE of long fits, of the brief suite of shorter ones.
double bestKnownRmse(const StabilityInputs& inputs, const Generator& generator, const StoredFunction& stored, const Theta& theta,
                     const LossOptions& loss) {
  DirectOptions options;
  if (inputs.is_short) options.adam_steps = 8000, options.restarts = 1;
  NormalEquationsKernel kernel;
  const WeightingFunction function = decodeFunction(stored, pointOrder(generator.representation()), loss);
  return fitLong(generator, function, theta, options, &kernel)[static_cast<size_t>(LongFit::best_known)].rmse;
}

}  // namespace

SampledFunction sampleFunction(const std::function<double(int)>& phi, const std::function<bool(int)>& valid) {
  SampledFunction function;
  for (int p = 0; p < kSupportPointCount; ++p) {
    if (valid(p)) {
      function.phi[p] = static_cast<uint8_t>(std::lround(255.0 * std::clamp(phi(p), 0.0, 1.0)));
    } else {
      function.validity[p / 8] = static_cast<uint8_t>(function.validity[p / 8] & ~(1 << (p % 8)));
    }
  }
  return function;
}

SampledFunction functionBesideWall(uint64_t seed, double distance) {
  Random random(seed);
  double normal[3], square = 0.0;
  for (double& n : normal) n = random.normal(), square += n * n;
  const auto height = [=](int p) {
    const LocalPoint& point = pointAt(p);
    return (normal[0] * point[0] + normal[1] * point[1] + normal[2] * point[2]) / std::sqrt(square) - distance;
  };
  return sampleFunction([&](int p) { return height(p) < 0.0 ? tent(pointAt(p)) : 0.0f; },
                        [&](int p) { return height(p) < 0.0 || height(p) > 0.1; });
}

void WorstBake::add(const StabilityInputs& inputs, const NamedGenerator& named, const StoredFunction& stored, ErrorBound bound,
                    const PolicyOptions& options) {
  const CheckOptions& check = options.check();
  ThetaPolicy policy({&named.generator}, options, ThetaStage::larger);
  MadeTheta made, unrefined;
  policy.bake(&stored, 1, &made);
  policy.make(&stored, 1, &unrefined);
  const FunctionCheck &network = made.record.at(ThetaWord::network), &last = made.check(), &before = unrefined.check();
  const FunctionCheck& corrected = made.record.at(ThetaWord::corrected);
  // what fits minimise, and what decides between two theta
  const auto error = [&](const FunctionCheck& of) { return of.blend_rmse; };

  ++bake_count_;
  failing_count_ += !last.passes(check);
  is_finite_ = is_finite_ && std::isfinite(last.rmse) && allFinite(made.theta);
  // a correction must not raise the error, nothing after it the trouble
  never_worse_ = never_worse_ && !(error(corrected) > error(network) * kOtherKernel);
  if (!made.isBareTent()) {
    never_worse_ = never_worse_ && !(error(before) > error(corrected) * kOtherKernel) &&
                   !(last.trouble(check) > before.trouble(check)) && (last.passes(check) || !network.passes(check));
  }
  network_rmse_ = std::max(network_rmse_, network.rmse);
  corrected_rmse_ = std::max(corrected_rmse_, corrected.rmse);
  stored_rmse_ = std::max(stored_rmse_, last.rmse);

  // either RMSE against its tau, whichever is nearer
  const bool is_by_blend = last.blend_rmse / check.tau_blend > last.rmse / check.tau_rmse;
  double reached = is_by_blend ? last.blend_rmse : last.rmse, most = is_by_blend ? check.tau_blend : check.tau_rmse;
  std::string from = is_by_blend ? "tau_blend" : "tau_rmse";
  const auto mayBe = [&](double of, double limit, const char* why) {
    if (of / limit < reached / most) reached = of, most = limit, from = why;
  };
  if (bound == ErrorBound::constant) {
    // by what fits minimise, or by what a bake chooses by: of two theta it takes the one in less trouble, whose blend RMSE may be larger
    const FunctionCheck constant = checkOfConstant(named.generator.representation(), stored, check);
    mayBe(error(last), kConstantFactor * error(constant), "a constant");
    mayBe(last.trouble(check), kConstantFactor * constant.trouble(check), "a constant's trouble");
  } else if (reached > most && !made.isBareTent()) {  // what is good enough asks for no long fits
    const double best = bestKnownRmse(inputs, named.generator, stored, made.theta, check.loss());
    mayBe(error(last), kBestKnownFactor * best, "the best known");
  }
  // in this order, so that an error that is no number counts as the worst
  if (reached / most <= most_of_bound_) return;
  most_of_bound_ = reached / most;
  nearest_ = fmt::format("nearest to its bound: {:.4f} of {:.4f} by {}, {}", reached, most, from, named.name);
}

void WorstBake::report(StabilityFigures* figures) const {
  if (bake_count_ == 0) return;
  figures->show("rmse_network", network_rmse_);
  figures->show("rmse_corrected", corrected_rmse_);
  figures->show("rmse_stored", stored_rmse_);
  figures->atMost("stored_over_bound", most_of_bound_, 1.0);
  figures->remark(nearest_);
  figures->show("bakes", bake_count_);
  figures->show("bakes_that_fail_the_check", failing_count_);
  figures->require(is_finite_, "a theta or its error is not finite");
  figures->require(never_worse_, "a stage made theta worse");
  figures->fails_check = failing_count_ > 0;
}

}  // namespace nlg
