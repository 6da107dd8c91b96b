// Stiff and extreme data: weighting functions as a data set may hold them, most of which no geometry makes; generators on coefficients far
// from all that training saw, against the formulas in double, on every SIMD target.

#include <algorithm>
#include <cmath>

#include "nlg/simd.h"
#include "runtime_eval/evaluator/evaluate.h"
#include "runtime_eval/evaluator/generator/generator_data.h"
#include "runtime_eval/numbers/finite.h"
#include "runtime_eval/numbers/random.h"
#include "validate/stability/extreme_function.h"
#include "validate/stability/stability_case.h"

namespace nlg {
namespace {

// Seven products of up to 1024 terms a function, each rounded once: 7 x 1024 x 2^-24, where nothing cancels.
constexpr double kRelativeBound = 4.3e-4;

// Of a generator with so many, in standard deviations.
using Coefficient = std::function<double(int k, int count)>;

// The nearest function that can be stored to the one that has these coefficients, valid everywhere. Of components of samples, whose
// channels are not independent, what they weigh of phi says at which sample points it is high.
SampledFunction functionOf(const BasisData& basis, const Coefficient& coefficient) {
  const bool is_stored = basis.input == GeneratorInput::coefficients;
  const int length = inputCount(basis.input);
  std::vector<double> classes(basis.mean.begin(), basis.mean.end());
  classes.resize(size_t{kParityClassCount} * kOctantPointCount);
  int k = 0;
  for (int c = 0; c < kParityClassCount; ++c) {
    for (const int end = k + basis.class_count[c]; k < end; ++k) {
      const double amount = coefficient(k, basis.coefficientCount()) * basis.deviation[k];
      for (int i = 0; i < (is_stored ? kOctantPointCount : kOctantSampleCount); ++i)
        classes[c * kOctantPointCount + (is_stored ? i : octantSamples()[i])] +=
            amount * basis.components[size_t(k) * length + i];
    }
  }
  return sampleFunction([&](int p) {
    double sum = 0.0;
    for (int c = 0; c < kParityClassCount; ++c)
      sum += mirrorSign(c, p / kOctantPointCount) * classes[c * kOctantPointCount + p % kOctantPointCount];
    return sum / std::sqrt(8.0);
  });
}

// Largest |theta - reference| over the largest |reference| on the SIMD target in force; *output: of what theta stands for, absolute.
double relativeError(const NamedGenerator& named, const StoredFunction& function, double* output) {
  const Representation& representation = named.generator.representation();
  // the reference in double, of the same float weights
  const std::vector<double> reference = generateReference(named.data, function);
  GeneratorScratch scratch(named.generator);
  Theta theta(reference.size());
  named.generator.generate(&function, 1, theta.data(), &scratch);
  if (!allFinite(theta)) return std::numeric_limits<double>::infinity();
  double largest = 0.0, error = 0.0;
  for (size_t k = 0; k < theta.size(); ++k) {
    largest = std::max(largest, std::fabs(reference[k]));
    error = std::max(error, std::fabs(theta[k] - reference[k]));
  }
  // an error of theta matters by what theta stands for: both are measured
  const PointSet points = makePointSet(supportPattern().points);
  AlignedFloats values(points.padded_count);
  evaluate(representation, points, theta.data(), values.data());
  for (int p = 0; p < points.count; p += 61) {
    if (!std::isfinite(values[p])) return std::numeric_limits<double>::infinity();
    *output = std::max(*output, std::fabs(values[p] - evaluateReference(representation, pointAt(p), reference.data())));
  }
  return error / largest;
}

void measureCoefficients(const StabilityInputs& inputs, const Coefficient& coefficient, StabilityFigures* figures) {
  const std::string before(chosenSimdTarget());
  double output = 0.0;
  for (const std::string_view target : availableSimdTargets()) {
    forceSimdTarget(target);
    double worst = 0.0;
    for (const NamedGenerator& named : inputs.generators)
      worst = std::max(worst, relativeError(named, functionOf(named.data.basis, coefficient).view(), &output));
    figures->atMost("relative_error_" + std::string(target), worst, kRelativeBound);
  }
  forceSimdTarget(before);
  figures->show("output_error", output);
  // what a bake makes of it
  WorstBake bakes;
  for (const NamedGenerator& named : inputs.generators) {
    bakes.add(inputs, named, functionOf(named.data.basis, coefficient).view(), ErrorBound::constant);
  }
  bakes.report(figures);
}

StabilityCase coefficientCase(const std::string& name, const Coefficient& coefficient) {
  return {
      "generator", name,
      "theta and what it stands for are finite on every SIMD target, theta is within 4.3e-4 of the largest number of the "
      "formulas in double, no stage of a bake makes it worse, and what the bake stores of the nearest storable function is at "
      "most as far off as the check allows, or 1.01 times what one constant does",
      [coefficient](const StabilityInputs& inputs, StabilityFigures* figures) {
        measureCoefficients(inputs, coefficient, figures);
      }};
}

// Every coefficient so many deviations out, signs drawn at random.
Coefficient farOut(double deviations) {
  return [deviations](int k, int) { return mixSeed(31, static_cast<uint64_t>(k)) & 1 ? deviations : -deviations; };
}

// Cells of a quarter of the spacing, black and white.
double checkerboard(int p) {
  int sum = 0;
  for (const float x : pointAt(p)) sum += static_cast<int>(std::floor(4.0f * (x + 1.0f)));
  return sum % 2 == 0 ? 1.0 : 0.0;
}

double distanceFromProbe(int p) { return std::hypot(pointAt(p)[0], pointAt(p)[1], pointAt(p)[2]); }

SampledFunction noise(uint64_t seed) {
  return sampleFunction([=](int p) { return static_cast<double>(mixSeed(seed, static_cast<uint64_t>(p)) % 256) / 255.0; });
}

SampledFunction waves(uint64_t seed) {
  const double length = 2.0 + static_cast<double>(seed % 8);
  return sampleFunction(
      [=](int p) { return 0.5 + 0.5 * std::sin(length * (pointAt(p)[0] + 0.7 * pointAt(p)[1] - 0.3 * pointAt(p)[2])); });
}

SampledFunction hollowSphere(uint64_t seed) {
  const double radius = 0.2 + 0.1 * static_cast<double>(seed % 8);
  return sampleFunction([=](int p) { return std::fabs(distanceFromProbe(p) - radius) < 0.1 ? 1.0 : 0.0; });
}

// A tent of random pieces, some of them in solid.
SampledFunction scatteredTent(uint64_t seed) {
  return sampleFunction([=](int p) { return mixSeed(seed, static_cast<uint64_t>(p / 32)) & 1 ? double{tent(pointAt(p))} : 0.0; },
                        [=](int p) { return mixSeed(seed + 1, static_cast<uint64_t>(p / 16)) % 4 != 0; });
}

// seed_count   how many seeds the whole suite makes of a family that no generator was trained on
StabilityCase sampledCase(const std::string& name, const std::function<SampledFunction(uint64_t seed)>& make,
                          uint64_t seed_count = 1) {
  return {
      "functions", name,
      "every generator's theta is finite, no stage of the bake makes it worse, and the error of what a bake stores is at most "
      "what the check allows, or 1.01 times that of the best constant in place of the network or field",
      [=](const StabilityInputs& inputs, StabilityFigures* figures) {
        WorstBake worst;
        for (uint64_t n = 0; n < (inputs.is_short ? 1 : seed_count); ++n)
          worst.addAll(inputs, make(500 + n).view(), ErrorBound::constant);
        worst.report(figures);
      }};
}

void measureBareTent(const StabilityInputs& inputs, StabilityFigures* figures) {
  PolicyOptions every_function_has_theta;
  every_function_has_theta.bare_tent_rmse = 0.0;
  WorstBake worst;
  worst.addAll(inputs, sampleFunction([](int p) { return tent(pointAt(p)); }).view(), ErrorBound::best_known,
               every_function_has_theta);
  worst.report(figures);
}

}  // namespace

std::vector<StabilityCase> coefficientCases() {
  return {
      coefficientCase("all coefficients zero", [](int, int) { return 0.0; }),
      coefficientCase("a single coefficient, 10 deviations out", [](int k, int count) { return k == count / 2 ? 10.0 : 0.0; }),
      coefficientCase("coefficients 10 deviations out", farOut(10.0)),
      coefficientCase("coefficients 100 deviations out", farOut(100.0)),
      coefficientCase("coefficients 1000 deviations out", farOut(1000.0)),
  };
}

std::vector<StabilityCase> sampledFunctionCases() {
  const auto constant = [](double value, bool valid) {
    return [=](uint64_t) { return sampleFunction([=](int) { return value; }, [=](int) { return valid; }); };
  };
  return {
      {"functions", "free space",
       "a bake that gives even the bare tent a theta holds it to what the check allows with every generator, or to 1.5 times the "
       "best "
       "known",
       measureBareTent},
      sampledCase("zero at every point", constant(0.0, true)),
      sampledCase("one at every point", constant(1.0, true)),
      // in the middle of the octant's curve: not at the probe, not at the border
      sampledCase(
          "one valid point",
          [](uint64_t) { return sampleFunction([](int) { return 1.0; }, [](int p) { return p == kOctantPointCount / 2; }); }),
      sampledCase("no valid point", constant(0.0, false)),
      sampledCase("checkerboard", [](uint64_t) { return sampleFunction(checkerboard); }),
      sampledCase("step from 0 to 1 between neighbours",
                  [](uint64_t) { return sampleFunction([](int p) { return pointAt(p)[0] > 0.0f ? 1.0 : 0.0; }); }),
      sampledCase("noise", noise, 4),
      sampledCase("waves", waves, 4),
      sampledCase("hollow spheres", hollowSphere, 4),
      sampledCase("scattered tents", scatteredTent, 4),
  };
}

}  // namespace nlg
