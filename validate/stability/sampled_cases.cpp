// Stiff and extreme weighting functions as a data set may hold them, most of which no geometry makes.

#include <cmath>

#include "runtime_eval/numbers/random.h"
#include "validate/stability/extreme_function.h"

namespace nlg {
namespace {

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

StabilityCase sampledCase(const std::string& name, const std::function<SampledFunction()>& make) {
  return {
      "functions",
      name,
      "every generator's theta is finite, no stage of the bake makes it worse, and the error of what a bake stores is at most "
      "what the check allows, or 1.01 times what one constant does at best in the place of the whole network or field",
      StabilityDepth::brief,
      true,
      [make](const StabilityInputs& inputs, StabilityFigures* figures) {
        WorstBake worst;
        worst.addAll(inputs, make().view(), ErrorBound::constant);
        worst.report(figures);
      }};
}

// Some functions of a family that no generator was trained on.
StabilityCase familyCase(const std::string& name, SampledFunction (*make)(uint64_t seed)) {
  StabilityCase family = sampledCase(name, {});
  family.measure = [make](const StabilityInputs& inputs, StabilityFigures* figures) {
    WorstBake worst;
    for (uint64_t n = 0; n < (inputs.isBrief() ? 1 : 4); ++n) worst.addAll(inputs, make(500 + n).view(), ErrorBound::constant);
    worst.report(figures);
  };
  return family;
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

std::vector<StabilityCase> sampledFunctionCases() {
  const auto constant = [](double value, bool valid) {
    return [=] { return sampleFunction([=](int) { return value; }, [=](int) { return valid; }); };
  };
  return {
      {"functions", "free space",
       "a bake that gives even the bare tent a theta holds it to what the check allows with every generator, or to 1.5 times the "
       "best "
       "known",
       StabilityDepth::brief, true, measureBareTent},
      sampledCase("zero at every point", constant(0.0, true)),
      sampledCase("one at every point", constant(1.0, true)),
      // in the middle of the octant's curve: not at the probe, not at the border
      sampledCase("one valid point",
                  [] { return sampleFunction([](int) { return 1.0; }, [](int p) { return p == kOctantPointCount / 2; }); }),
      sampledCase("no valid point", constant(0.0, false)),
      sampledCase("checkerboard", [] { return sampleFunction(checkerboard); }),
      sampledCase("step from 0 to 1 between neighbours",
                  [] { return sampleFunction([](int p) { return pointAt(p)[0] > 0.0f ? 1.0 : 0.0; }); }),
      familyCase("noise", noise),
      familyCase("waves", waves),
      familyCase("hollow spheres", hollowSphere),
      familyCase("scattered tents", scatteredTent),
  };
}

}  // namespace nlg
