// Stiff and extreme weighting functions as a data set may hold them, and the one of free space.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "validate/stability/extreme_function.h"
#include "validate/stability/face_scene.h"

namespace nlg {
namespace {

constexpr const char* kSampledMustHold =
    "every generator's theta is finite, neither correction nor refinement makes it worse, and the error of what a bake stores is "
    "at most the threshold tau or that of answering 0 everywhere";

StabilityResult measureSampled(const StabilityInputs& inputs, const SampledFunction& function) {
  const double zero = rmseOfZero(function), tau = CheckOptions{}.tau_rmse;
  const WorstBake worst = worstBake(inputs, function.view());
  StabilityResult result;
  result.passes = worst.is_finite && worst.never_worse && worst.final_rmse <= std::max(tau, zero);
  result.measured = fmt::format(
      "worst RMSE over {} generators: network {:.4f}, corrected {:.4f}, stored {:.4f} ({}), best stored {:.4f}; "
      "answering 0: {:.4f}",
      inputs.generators.size(), worst.generated_rmse, worst.corrected_rmse, worst.final_rmse, worst.final_name,
      worst.best_final_rmse, zero);
  result.figures = {{"rmse_generated", worst.generated_rmse},    {"rmse_corrected", worst.corrected_rmse},
                    {"rmse_stored", worst.final_rmse},           {"rmse_stored_best", worst.best_final_rmse},
                    {"failing_generators", worst.failing_count}, {"rmse_of_zero", zero}};
  if (worst.failing_count > 0) {
    result.note = fmt::format("{} of {} generators do not hold such a function: the bake's check fails it and counts it.",
                              worst.failing_count, inputs.generators.size());
  }
  return result;
}

StabilityCase sampledCase(const std::string& name, const std::function<SampledFunction()>& make) {
  return {"functions",           name, kSampledMustHold,
          StabilityDepth::brief, true, [make](const StabilityInputs& inputs) { return measureSampled(inputs, make()); }};
}

SampledFunction onePoint() {
  // in the middle of the octant's curve: not at the probe, not at the border
  constexpr int kOnly = kOctantPointCount / 2;
  return sampleFunction([](int) { return 1.0; }, [](int p) { return p == kOnly; });
}

// Cells of a quarter of the spacing, black and white.
SampledFunction checkerboard() {
  return sampleFunction([](int p) {
    int sum = 0;
    for (const float x : pointAt(p)) sum += static_cast<int>(std::floor(4.0f * (x + 1.0f)));
    return sum % 2 == 0 ? 1.0 : 0.0;
  });
}

StabilityResult measureFreeSpace(const StabilityInputs& inputs) {
  FaceScene faces;
  faces.addBox({3, -1, -1}, {4, 1, 1});
  const Scene scene = faces.finish();
  const ProbeOutcome outcome = functionsAt(scene, {-scene.origin_m}, 1.0f).outcomes.front();
  const SampledFunction tents = sampleFunction([](int p) { return tent(pointAt(p)); });
  StabilityResult result;
  double rmse = 0.0;
  if (!inputs.generators.empty()) rmse = worstBake(inputs, tents.view()).final_rmse;
  result.passes = outcome == ProbeOutcome::free_space && rmse <= CheckOptions{}.tau_rmse;
  result.measured = fmt::format("outcome {}; worst RMSE of the tent in what a bake stores {:.4f}", outcomeName(outcome), rmse);
  result.figures = {{"rmse_stored", rmse}};
  return result;
}

}  // namespace

std::vector<StabilityCase> sampledFunctionCases() {
  const auto constant = [](double value, bool valid) {
    return [=] { return sampleFunction([=](int) { return value; }, [=](int) { return valid; }); };
  };
  return {
      {"functions", "free space",
       "a probe without geometry in its support is found to be in free space, and every generator holds the bare tent to the "
       "threshold tau",
       StabilityDepth::brief, false, measureFreeSpace},
      sampledCase("zero at every point", constant(0.0, true)),
      sampledCase("one at every point", constant(1.0, true)),
      sampledCase("one valid point", onePoint),
      sampledCase("no valid point", constant(0.0, false)),
      sampledCase("checkerboard", checkerboard),
      sampledCase("step from 0 to 1 between neighbours",
                  [] { return sampleFunction([](int p) { return pointAt(p)[0] > 0.0f ? 1.0 : 0.0; }); }),
  };
}

}  // namespace nlg
