#include "validate/stability/extreme_function.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "runtime_eval/numbers/finite.h"
#include "runtime_eval/numbers/random.h"
#include "validate/errors/best_known.h"

namespace nlg {

SampledFunction sampleFunction(const std::function<double(int)>& phi, const std::function<bool(int)>& valid) {
  SampledFunction function;
  for (int p = 0; p < kSupportPointCount; ++p) {
    if (valid(p)) {
      function.phi[p] = static_cast<uint8_t>(std::lround(255.0 * phi(p)));
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

double rmseOfZero(const SampledFunction& function) {
  double sum = 0.0;
  int count = 0;
  for (int p = 0; p < kSupportPointCount; ++p) {
    if (!function.valid(p)) continue;
    sum += function.phi[p] * function.phi[p] / (255.0 * 255.0);
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : 0.0;
}

BakedFunction bakeFunction(const NamedGenerator& named, const StoredFunction& stored, const PolicyOptions& options) {
  ThetaPolicy policy({&named.generator}, options);
  MadeTheta made, before;
  policy.bake(&stored, 1, &made);
  policy.make(&stored, 1, &before);  // up to the refinement
  BakedFunction baked;
  baked.network_rmse = made.record.at(ThetaWord::network).rmse;
  baked.corrected_rmse = made.record.at(ThetaWord::corrected).rmse;
  baked.stored = made.check();
  baked.theta = made.theta;
  baked.fails_check = !baked.stored.passes(options.check());
  baked.is_finite = std::isfinite(baked.stored.rmse) && allFinite(baked.theta);
  // sums of another kernel: the same theta may differ in the last digits
  baked.never_worse = !(baked.corrected_rmse > baked.network_rmse * (1.0 + 1e-6));
  if (made.isBareTent()) return baked;
  const FunctionCheck& unrefined = before.check();
  baked.never_worse = baked.never_worse && !(unrefined.rmse > baked.corrected_rmse * (1.0 + 1e-6)) &&
                      !(baked.stored.trouble(options.check()) > unrefined.trouble(options.check())) &&
                      (baked.stored.passes(options.check()) || !made.record.at(ThetaWord::network).passes(options.check()));
  return baked;
}

double constantRmse(const Representation& representation, const StoredFunction& stored) {
  const bool has_tent = representation.tentFactor();
  const bool is_limited = representation.isField() || representation.shape().output == OutputFunction::sigmoid;
  double shape_shape = 0.0, shape_phi = 0.0, phi_phi = 0.0;
  int count = 0;
  for (int p = 0; p < kSupportPointCount; ++p) {
    if ((stored.validity[p / 8] >> (p % 8) & 1) == 0) continue;
    const double shape = has_tent ? double{tent(pointAt(p))} : 1.0, phi = stored.phi[p] / 255.0;
    shape_shape += shape * shape;
    shape_phi += shape * phi;
    phi_phi += phi * phi;
    ++count;
  }
  if (count == 0 || shape_shape == 0.0) return count == 0 ? 0.0 : std::sqrt(phi_phi / count);
  const double best = shape_phi / shape_shape, c = is_limited ? std::min(best, 1.0) : best;
  return std::sqrt(std::max(0.0, phi_phi - 2.0 * c * shape_phi + c * c * shape_shape) / count);
}

namespace {

// A fit long enough to know what the representation can do; of the brief suite a shorter one.
DirectOptions longFits(const StabilityInputs& inputs) {
  DirectOptions options;
  if (inputs.depth == StabilityDepth::brief) options.adam_steps = 8000, options.restarts = 1;
  return options;
}

struct Bound {
  double rmse = 0.0;
  std::string text;
};

Bound boundOf(const StabilityInputs& inputs, const NamedGenerator& named, const StoredFunction& stored,
              const BakedFunction& baked, ErrorBound kind) {
  const double tau = CheckOptions{}.tau_rmse;
  const Representation& representation = named.generator.representation();
  if (kind == ErrorBound::constant) {
    const double constant = constantRmse(representation, stored);
    return {std::max(tau, kConstantFactor * constant), fmt::format("{} (a constant: {:.4f})", named.name, constant)};
  }
  // what is good enough asks for no long fits
  if (baked.stored.rmse <= tau || baked.theta.empty()) return {tau, named.name};
  NormalEquationsKernel kernel;
  const FunctionFits fits =
      fitLong(named.generator, decodeFunction(stored, pointOrder(representation)), baked.theta, longFits(inputs), &kernel);
  const double best_known = fits.at(LongFit::best_known).rmse;
  return {std::max(tau, kBestKnownFactor * best_known),
          fmt::format("{} (best known {:.4f} by {})", named.name, best_known, fits.best_known_from)};
}

}  // namespace

void WorstBake::add(const WorstBake& other) {
  is_finite = is_finite && other.is_finite;
  never_worse = never_worse && other.never_worse;
  network_rmse = std::max(network_rmse, other.network_rmse);
  corrected_rmse = std::max(corrected_rmse, other.corrected_rmse);
  failing_count = std::max(failing_count, other.failing_count);
  best_stored_rmse = std::min(best_stored_rmse, other.best_stored_rmse);
  // in this order, so that an error that is no number counts as the worst
  if (stored_name.empty() || !(other.stored_rmse <= stored_rmse)) {
    stored_rmse = other.stored_rmse;
    stored_name = other.stored_name;
  }
  if (bound_text.empty() || !(other.most_of_bound <= most_of_bound)) {
    most_of_bound = other.most_of_bound;
    bound_rmse = other.bound_rmse;
    bound_text = other.bound_text;
  }
}

WorstBake worstBake(const StabilityInputs& inputs, const StoredFunction& stored, ErrorBound bound, const PolicyOptions& options) {
  WorstBake worst;
  int failing_count = 0;
  for (const NamedGenerator& generator : inputs.generators) {
    const BakedFunction baked = bakeFunction(generator, stored, options);
    failing_count += baked.fails_check;
    const double rmse = baked.stored.rmse;
    const Bound most = boundOf(inputs, generator, stored, baked, bound);
    worst.add({baked.is_finite, baked.never_worse, baked.network_rmse, baked.corrected_rmse, rmse, generator.name, 0, rmse,
               rmse / most.rmse, most.rmse, most.text});
  }
  worst.failing_count = failing_count;
  return worst;
}

std::string describeBound(const WorstBake& worst) {
  return fmt::format("nearest to its bound: {:.4f} of {:.4f}, {}", worst.most_of_bound * worst.bound_rmse, worst.bound_rmse,
                     worst.bound_text);
}

}  // namespace nlg
