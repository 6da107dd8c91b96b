// Stiff and extreme weighting functions as a data set may hold them, and the one of free space.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "validate/stability/extreme_function.h"
#include "validate/stability/face_scene.h"

namespace nlg {
namespace {

constexpr const char* kSampledMustHold =
    "every generator's theta is finite, no stage of the bake makes it worse, and the error of what a bake stores is at most the "
    "threshold tau, or 1.01 times what one constant does at best in the place of the whole network or field";

StabilityResult measureSampled(const StabilityInputs& inputs, const SampledFunction& function) {
  const WorstBake worst = worstBake(inputs, function.view(), ErrorBound::constant);
  StabilityResult result;
  result.holds = worst.holds();
  result.fails_check = worst.failing_count > 0;
  result.measured = fmt::format(
      "worst RMSE over {} generators: network {:.4f}, corrected {:.4f}, stored {:.4f} ({}), best stored {:.4f}; {}; {} of them "
      "fail the bake's check",
      inputs.generators.size(), worst.network_rmse, worst.corrected_rmse, worst.stored_rmse, worst.stored_name,
      worst.best_stored_rmse, describeBound(worst), worst.failing_count);
  result.figures = {{"rmse_network", worst.network_rmse},        {"rmse_corrected", worst.corrected_rmse},
                    {"rmse_stored", worst.stored_rmse},          {"rmse_stored_best", worst.best_stored_rmse},
                    {"failing_generators", worst.failing_count}, {"stored_over_bound", worst.most_of_bound},
                    {"rmse_of_zero", rmseOfZero(function)}};
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
  PolicyOptions every_function_has_theta;
  every_function_has_theta.bare_tent_rmse = 0.0;
  if (!inputs.generators.empty())
    rmse = worstBake(inputs, tents.view(), ErrorBound::best_known, every_function_has_theta).stored_rmse;
  result.holds = outcome == ProbeOutcome::free_space && rmse <= CheckOptions{}.tau_rmse;
  result.measured = fmt::format("outcome {}; worst RMSE of a theta for the tent {:.4f}", outcomeName(outcome), rmse);
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
       "a probe without geometry in its support is found to be in free space, and a bake that gives even the bare tent a theta "
       "holds it to the threshold tau with every generator",
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
