// Generators on coefficients far from all that training saw, against the formulas in double, on every SIMD target.

#include <algorithm>
#include <cmath>

#include "runtime_eval/evaluator/evaluate.h"
#include "runtime_eval/numbers/finite.h"
#include "runtime_eval/numbers/random.h"
#include "runtime_eval/simd/simd_target.h"
#include "validate/stability/extreme_function.h"

namespace nlg {
namespace {

// Seven products of up to 1024 terms a function, each rounded once: 7 x 1024 x 2^-24, where nothing cancels.
constexpr double kRelativeBound = 4.3e-4;

// Of a generator with so many, in standard deviations.
using Coefficient = std::function<double(int k, int count)>;

// The samples that have these coefficients, pattern order; they leave [0, 1] where the coefficients are absurd.
std::vector<float> samplesOf(const BasisData& basis, const Coefficient& coefficient) {
  std::vector<double> classes(basis.mean.begin(), basis.mean.end());
  int k = 0;
  for (int c = 0; c < kParityClassCount; ++c) {
    for (const int end = k + basis.class_count[c]; k < end; ++k) {
      const double amount = coefficient(k, basis.coefficientCount()) * basis.deviation[k];
      for (int i = 0; i < kOctantPointCount; ++i)
        classes[c * kOctantPointCount + i] += amount * basis.components[size_t(k) * kOctantPointCount + i];
    }
  }
  std::vector<float> phi(kSupportPointCount);
  for (int p = 0; p < kSupportPointCount; ++p) {
    double sum = 0.0;
    for (int c = 0; c < kParityClassCount; ++c)
      sum += mirrorSign(c, p / kOctantPointCount) * classes[c * kOctantPointCount + p % kOctantPointCount];
    phi[p] = static_cast<float>(sum / std::sqrt(8.0));
  }
  return phi;
}

// Largest |theta - reference| over the largest |reference| on the SIMD target in force; *output: of what theta stands for, absolute.
double relativeError(const NamedGenerator& named, const std::vector<float>& phi, double* output) {
  const Representation& representation = named.generator.representation();
  const std::vector<double> reference = generateReference(named.data, std::vector<double>(phi.begin(), phi.end()).data());
  GeneratorScratch scratch(named.generator);
  Theta theta(reference.size());
  named.generator.generate(phi.data(), 1, theta.data(), &scratch);
  if (!allFinite(theta)) return std::numeric_limits<double>::infinity();
  double largest = 0.0, error = 0.0;
  for (size_t k = 0; k < theta.size(); ++k) {
    largest = std::max(largest, std::fabs(reference[k]));
    error = std::max(error, std::fabs(theta[k] - reference[k]));
  }
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
      worst = std::max(worst, relativeError(named, samplesOf(named.data.basis, coefficient), &output));
    figures->atMost("relative_error_" + std::string(target), worst, kRelativeBound);
  }
  forceSimdTarget(before);
  figures->show("output_error", output);
  // what a bake makes of the nearest function that can be stored
  WorstBake bakes;
  for (const NamedGenerator& named : inputs.generators) {
    const std::vector<float> phi = samplesOf(named.data.basis, coefficient);
    bakes.add(inputs, named, sampleFunction([&](int p) { return phi[p]; }).view(), ErrorBound::constant);
  }
  bakes.report(figures);
}

StabilityCase coefficientCase(const std::string& name, StabilityDepth depth, const Coefficient& coefficient) {
  return {
      "generator",
      name,
      "theta and what it stands for are finite on every SIMD target, theta is within 4.3e-4 of the largest number of the "
      "formulas in double, no stage of a bake makes it worse, and what the bake stores of the nearest storable function is at "
      "most as far off as the check allows, or 1.01 times what one constant does",
      depth,
      true,
      [coefficient](const StabilityInputs& inputs, StabilityFigures* figures) {
        measureCoefficients(inputs, coefficient, figures);
      }};
}

// Every coefficient so many deviations out, signs drawn at random.
Coefficient farOut(double deviations) {
  return [deviations](int k, int) { return mixSeed(31, static_cast<uint64_t>(k)) & 1 ? deviations : -deviations; };
}

}  // namespace

std::vector<StabilityCase> coefficientCases() {
  const auto brief = StabilityDepth::brief, full = StabilityDepth::full;
  return {
      coefficientCase("all coefficients zero", brief, [](int, int) { return 0.0; }),
      coefficientCase("a single coefficient, 10 deviations out", full,
                      [](int k, int count) { return k == count / 2 ? 10.0 : 0.0; }),
      coefficientCase("coefficients 10 deviations out", full, farOut(10.0)),
      coefficientCase("coefficients 100 deviations out", full, farOut(100.0)),
      coefficientCase("coefficients 1000 deviations out", brief, farOut(1000.0)),
  };
}

}  // namespace nlg
