// Functions from families that no generator was trained on: none of them comes from geometry that casts shadows.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "runtime_eval/numbers/random.h"
#include "validate/stability/extreme_function.h"

namespace nlg {
namespace {

SampledFunction noise(uint64_t seed) {
  return sampleFunction([=](int p) { return static_cast<double>(mixSeed(seed, static_cast<uint64_t>(p)) % 256) / 255.0; });
}

SampledFunction waves(uint64_t seed) {
  const double length = 2.0 + static_cast<double>(seed % 8);
  return sampleFunction([=](int p) {
    const LocalPoint& at = pointAt(p);
    return 0.5 + 0.5 * std::sin(length * (at[0] + 0.7 * at[1] - 0.3 * at[2]));
  });
}

SampledFunction hollowSphere(uint64_t seed) {
  const double radius = 0.2 + 0.1 * static_cast<double>(seed % 8);
  return sampleFunction([=](int p) {
    const LocalPoint& at = pointAt(p);
    return std::fabs(std::hypot(at[0], at[1], at[2]) - radius) < 0.1 ? 1.0 : 0.0;
  });
}

// A tent of random pieces, some of them in solid.
SampledFunction scatteredTent(uint64_t seed) {
  return sampleFunction([=](int p) { return mixSeed(seed, static_cast<uint64_t>(p / 32)) & 1 ? double{tent(pointAt(p))} : 0.0; },
                        [=](int p) { return mixSeed(seed + 1, static_cast<uint64_t>(p / 16)) % 4 != 0; });
}

struct Family {
  const char* name;
  SampledFunction (*make)(uint64_t seed);
};
constexpr Family kFamilies[] = {
    {"noise", noise}, {"waves", waves}, {"hollow spheres", hollowSphere}, {"scattered tents", scatteredTent}};

StabilityResult measureFamilies(const StabilityInputs& inputs) {
  const int functions = inputs.depth == StabilityDepth::brief ? 1 : 4;
  StabilityResult result;
  result.passes = true;
  double over_zero = 0.0;
  for (const Family& family : kFamilies) {
    double generated = 0.0, stored = 0.0;
    for (int n = 0; n < functions; ++n) {
      const SampledFunction function = family.make(500 + static_cast<uint64_t>(n));
      const WorstBake worst = worstBake(inputs, function.view());
      generated = std::max(generated, worst.generated_rmse);
      stored = std::max(stored, worst.final_rmse);
      const double bound = std::max(CheckOptions{}.tau_rmse, rmseOfZero(function));
      over_zero = std::max(over_zero, worst.final_rmse / bound);
      result.passes = result.passes && worst.is_finite && worst.never_worse && worst.final_rmse <= bound;
    }
    result.measured +=
        fmt::format("{}{}: RMSE {:.3f} -> {:.3f}", result.measured.empty() ? "" : "; ", family.name, generated, stored);
    std::string key = family.name;
    std::replace(key.begin(), key.end(), ' ', '_');
    result.figures["rmse_generated_" + key] = generated;
    result.figures["rmse_stored_" + key] = stored;
  }
  result.figures["worst_over_answering_0"] = over_zero;
  result.note =
      "Worst of all generators, network alone -> what a bake stores. What stays above tau fails the bake's check and is counted.";
  return result;
}

}  // namespace

std::vector<StabilityCase> heldOutFamilyCases() {
  return {
      {"generator", "families that were never trained on",
       "every generator's theta is finite, neither correction nor refinement makes it worse, and what a bake stores errs by no "
       "more than the threshold tau or answering 0",
       StabilityDepth::brief, true, measureFamilies}};
}

}  // namespace nlg
