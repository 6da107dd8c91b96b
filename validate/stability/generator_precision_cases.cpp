// Generators on coefficients far from all that training saw, against the formulas in double, on every SIMD target.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "runtime_eval/evaluator/evaluate.h"
#include "runtime_eval/numbers/finite.h"
#include "runtime_eval/numbers/random.h"
#include "runtime_eval/simd/simd_target.h"
#include "validate/stability/extreme_function.h"

namespace nlg {
namespace {

// The samples whose standardised coefficients are these, pattern order; they leave [0, 1] where the coefficients are absurd.
// coefficients   K
std::vector<float> samplesOf(const BasisData& basis, const std::vector<double>& coefficients) {
  std::vector<double> classes(basis.mean.begin(), basis.mean.end());
  int k = 0;
  for (int c = 0; c < kParityClassCount; ++c) {
    for (const int end = k + basis.class_count[c]; k < end; ++k) {
      const double amount = coefficients[k] * basis.deviation[k];
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

// The difference of one generator from its formulas in double, over all functions: the worst on each SIMD target.
struct Precision {
  bool finite = true;
  std::map<std::string, double> relative;  // by target: largest |theta - reference| over largest |reference|
  double output = 0.0;                     // largest difference of what theta stands for, at support points
  double worst() const {
    double largest = 0.0;
    for (const auto& [target, error] : relative) largest = std::max(largest, error);
    return largest;
  }
};

// phi   count x P
void comparePrecision(const NamedGenerator& named, const std::vector<float>& phi, Precision* precision) {
  const size_t count = phi.size() / kSupportPointCount;
  const Representation& representation = named.generator.representation();
  const PointSet points = makePointSet(supportPattern().points);
  AlignedFloats values(points.padded_count);
  GeneratorScratch scratch(named.generator);
  for (size_t n = 0; n < count; ++n) {
    const std::vector<double> exact(phi.begin() + static_cast<ptrdiff_t>(n * kSupportPointCount),
                                    phi.begin() + static_cast<ptrdiff_t>((n + 1) * kSupportPointCount));
    const std::vector<double> reference = generateReference(named.data, exact.data());
    double largest = 0.0;
    for (const double value : reference) largest = std::max(largest, std::fabs(value));
    for (const std::string_view target : availableSimdTargets()) {
      forceSimdTarget(target);
      Theta theta(reference.size());
      named.generator.generate(&phi[n * kSupportPointCount], 1, theta.data(), &scratch);
      double error = 0.0;
      for (size_t k = 0; k < theta.size(); ++k) {
        precision->finite = precision->finite && std::isfinite(theta[k]);
        error = std::max(error, std::fabs(theta[k] - reference[k]));
      }
      double& relative = precision->relative[std::string(target)];
      relative = std::max(relative, error / largest);
      evaluate(representation, points, theta.data(), values.data());
      for (int p = 0; p < points.count; p += 61) {
        precision->finite = precision->finite && std::isfinite(values[p]);
        precision->output =
            std::max(precision->output,
                     std::fabs(values[p] - evaluateReference(representation, supportPattern().points[p], reference.data())));
      }
    }
  }
}

// All generators on the samples that `make` gives for each.
Precision comparePrecision(const StabilityInputs& inputs, const std::function<std::vector<float>(const NamedGenerator&)>& make) {
  const std::string before(chosenSimdTarget());
  Precision precision;
  for (const NamedGenerator& named : inputs.generators) comparePrecision(named, make(named), &precision);
  forceSimdTarget(before);
  return precision;
}

std::string byTarget(const Precision& precision) {
  std::string text;
  for (const auto& [target, error] : precision.relative)
    text += fmt::format("{}{} {:.1e}", text.empty() ? "" : ", ", target, error);
  return text;
}

void addFigures(const Precision& precision, StabilityResult* result) {
  for (const auto& [target, error] : precision.relative) result->figures["relative_error_" + target] = error;
  result->figures["output_error"] = precision.output;
}

// Half a step of the bytes that functions are stored in: a difference that nobody's phi can show.
constexpr double kHalfStep = 0.5 / 255.0;
// Seven products of up to 1024 terms a function, each rounded once: 7 x 1024 x 2^-24, where nothing cancels.
constexpr double kRelativeBound = 4.3e-4;

// --- ordinary functions -----------------------------------------------------------------------------------------------------

std::vector<SampledFunction> ordinaryFunctions(int count) {
  std::vector<SampledFunction> functions;
  for (int n = 0; n < count; ++n) functions.push_back(functionBesideWall(400 + static_cast<uint64_t>(n), 0.05 + 0.1 * (n % 7)));
  return functions;
}

// How many generators give other bits in int16 on some SIMD target than on the first; *finite: no more, where one is not finite.
int generatorsThatDifferInInt16(const StabilityInputs& inputs, const std::vector<SampledFunction>& functions, bool* finite) {
  const std::string before(chosenSimdTarget());
  int different = 0;
  for (const NamedGenerator& named : inputs.generators) {
    const Generator integer(named.data, GeneratorPrecision::int16);
    GeneratorScratch scratch(integer);
    std::vector<Theta> by_target;
    for (const std::string_view target : availableSimdTargets()) {
      forceSimdTarget(target);
      const size_t count = named.data.theta0.size();
      Theta theta(functions.size() * count);
      for (size_t n = 0; n < functions.size(); ++n) integer.generate(functions[n].phi.data(), 1, &theta[n * count], &scratch);
      *finite = *finite && allFinite(theta);
      by_target.push_back(std::move(theta));
    }
    different += std::any_of(by_target.begin(), by_target.end(), [&](const Theta& theta) { return theta != by_target.front(); });
  }
  forceSimdTarget(before);
  return different;
}

StabilityResult measureOrdinary(const StabilityInputs& inputs) {
  const std::vector<SampledFunction> functions = ordinaryFunctions(inputs.depth == StabilityDepth::brief ? 3 : 16);
  std::vector<float> phi;
  for (const SampledFunction& function : functions) {
    for (const uint8_t byte : function.phi) phi.push_back(byte / 255.0f);
  }
  Precision precision = comparePrecision(inputs, [&](const NamedGenerator&) { return phi; });
  const int different = generatorsThatDifferInInt16(inputs, functions, &precision.finite);
  StabilityResult result;
  result.holds = precision.finite && precision.worst() <= kRelativeBound && precision.output <= kHalfStep && different == 0;
  result.measured = fmt::format(
      "{} functions, largest relative error of theta: {}; of what it stands for: {:.1e}; {} generators whose int16 bits differ "
      "between targets",
      functions.size(), byTarget(precision), precision.output, different);
  addFigures(precision, &result);
  result.figures["int16_generators_that_differ"] = different;
  return result;
}

// --- coefficients far out ---------------------------------------------------------------------------------------------------

// What a bake makes of the nearest function that can be stored.
BakedFunction bakeNearest(const NamedGenerator& named, const std::vector<float>& phi) {
  const SampledFunction stored =
      sampleFunction([&](int p) { return std::clamp<double>(phi[p], 0.0, 1.0); }, [](int) { return true; });
  return bakeFunction(named, stored.view());
}

using Coefficients = std::function<double(int k, int count)>;

StabilityResult measureCoefficients(const StabilityInputs& inputs, const Coefficients& coefficient) {
  const auto samples = [&](const NamedGenerator& named) {
    const int count = named.data.basis.coefficientCount();
    std::vector<double> coefficients;
    for (int k = 0; k < count; ++k) coefficients.push_back(coefficient(k, count));
    return samplesOf(named.data.basis, coefficients);
  };
  const Precision precision = comparePrecision(inputs, samples);
  bool finite = precision.finite, never_worse = true;
  double stored = 0.0;
  int failing = 0;
  for (const NamedGenerator& named : inputs.generators) {
    const BakedFunction baked = bakeNearest(named, samples(named));
    finite = finite && baked.is_finite;
    never_worse = never_worse && baked.never_worse;
    stored = std::max(stored, baked.stored.rmse);
    failing += baked.fails_check;
  }
  StabilityResult result;
  result.fails_check = failing > 0;
  result.holds = finite && never_worse && precision.worst() <= kRelativeBound;
  result.measured = fmt::format(
      "largest relative error of theta: {}; {}; worst RMSE of what a bake stores for the nearest storable function {:.4f}, {} of "
      "{} "
      "fail its check",
      byTarget(precision), finite ? "all finite" : "NOT FINITE", stored, failing, inputs.generators.size());
  addFigures(precision, &result);
  result.figures["rmse_stored"] = stored;
  result.figures["failing_generators"] = failing;
  return result;
}

StabilityCase coefficientCase(const std::string& name, StabilityDepth depth, const Coefficients& coefficient) {
  return {"generator",
          name,
          "theta and what it stands for are finite on every SIMD target, theta is within 4.3e-4 of the largest number of the "
          "formulas in double, and no stage of the bake makes it worse",
          depth,
          true,
          [coefficient](const StabilityInputs& inputs) { return measureCoefficients(inputs, coefficient); }};
}

// Every coefficient so many deviations out, signs drawn at random.
Coefficients farOut(double deviations) {
  return [deviations](int k, int) { return mixSeed(31, static_cast<uint64_t>(k)) & 1 ? deviations : -deviations; };
}

}  // namespace

std::vector<StabilityCase> generatorPrecisionCases() {
  const auto brief = StabilityDepth::brief, full = StabilityDepth::full;
  return {
      {"generator", "float32 and int16 on every SIMD target",
       "on ordinary functions float32 is within 4.3e-4 of the formulas in double and what theta stands for within half a step of "
       "the stored bytes, on every SIMD target; int16 gives the same bits on all of them",
       brief, true, measureOrdinary},
      coefficientCase("all coefficients zero", brief, [](int, int) { return 0.0; }),
      coefficientCase("a single coefficient, 10 deviations out", full,
                      [](int k, int count) { return k == count / 2 ? 10.0 : 0.0; }),
      coefficientCase("coefficients 10 deviations out", full, farOut(10.0)),
      coefficientCase("coefficients 100 deviations out", full, farOut(100.0)),
      coefficientCase("coefficients 1000 deviations out", brief, farOut(1000.0)),
  };
}

}  // namespace nlg
