#include "validate/stability/extreme_function.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/fit/correction.h"
#include "runtime_eval/numbers/finite.h"
#include "runtime_eval/numbers/random.h"

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

BakedFunction bakeFunction(const NamedGenerator& named, const StoredFunction& stored, const RefinementOptions& options) {
  const Generator& generator = named.generator;
  const Representation& representation = generator.representation();
  const Theta theta0(generator.theta0(), generator.theta0() + representation.thetaCount());
  GeneratorScratch scratch(generator);
  Corrector corrector(generator);
  FunctionChecker checker;
  Theta theta(representation.thetaCount());
  BakedFunction baked;

  generator.generate(stored.phi, 1, theta.data(), &scratch);
  baked.generated_rmse = checker.check(representation, stored, theta.data(), options.check).rmse;
  corrector.correct(&stored, 1, theta.data());
  baked.check = checker.check(representation, stored, theta.data(), options.check);
  baked.corrected_rmse = baked.check.rmse;
  // sums of another kernel: the same theta may differ in the last digits
  baked.never_worse = baked.corrected_rmse <= baked.generated_rmse * (1.0 + 1e-6);
  if (!baked.check.passes(options.check)) {
    const double trouble = baked.check.trouble(options.check);
    Refiner refiner;
    const RefinementResult refined = refiner.refine(representation, stored, theta, theta0, options);
    theta = refined.theta;
    baked.check = checker.check(representation, stored, theta.data(), options.check);
    baked.never_worse = baked.never_worse && baked.check.trouble(options.check) <= trouble;
  }
  baked.is_finite = std::isfinite(baked.check.rmse) && allFinite(theta);
  return baked;
}

RefinementOptions bakeOptions(const StabilityInputs& inputs) {
  RefinementOptions options;
  if (inputs.depth == StabilityDepth::brief) options.rounds = 1;
  return options;
}

WorstBake worstBake(const StabilityInputs& inputs, const StoredFunction& stored) {
  WorstBake worst;
  const RefinementOptions options = bakeOptions(inputs);
  for (const NamedGenerator& generator : inputs.generators) {
    const BakedFunction baked = bakeFunction(generator, stored, options);
    worst.failing_count += !baked.check.passes(options.check);
    worst.best_final_rmse = std::min(worst.best_final_rmse, baked.check.rmse);
    worst.is_finite = worst.is_finite && baked.is_finite;
    worst.never_worse = worst.never_worse && baked.never_worse;
    worst.generated_rmse = std::max(worst.generated_rmse, baked.generated_rmse);
    worst.corrected_rmse = std::max(worst.corrected_rmse, baked.corrected_rmse);
    if (worst.final_name.empty() || !(baked.check.rmse <= worst.final_rmse)) {
      worst.final_rmse = baked.check.rmse;
      worst.final_name = generator.name;
    }
  }
  return worst;
}

}  // namespace nlg
