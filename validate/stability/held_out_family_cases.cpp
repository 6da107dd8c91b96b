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
  result.holds = true;
  double over_bound = 0.0;
  int failing = 0;
  for (const Family& family : kFamilies) {
    double network = 0.0, stored = 0.0;
    for (int n = 0; n < functions; ++n) {
      const SampledFunction function = family.make(500 + static_cast<uint64_t>(n));
      const WorstBake worst = worstBake(inputs, function.view(), ErrorBound::constant);
      network = std::max(network, worst.network_rmse);
      stored = std::max(stored, worst.stored_rmse);
      over_bound = std::max(over_bound, worst.most_of_bound);
      failing += worst.failing_count;
      result.holds = result.holds && worst.holds();
    }
    result.measured +=
        fmt::format("{}{}: RMSE {:.3f} -> {:.3f}", result.measured.empty() ? "" : "; ", family.name, network, stored);
    std::string key = family.name;
    std::replace(key.begin(), key.end(), ' ', '_');
    result.figures["rmse_network_" + key] = network;
    result.figures["rmse_stored_" + key] = stored;
  }
  result.figures["stored_over_bound"] = over_bound;
  result.figures["failing"] = failing;
  result.fails_check = failing > 0;
  result.measured += fmt::format("; at most {:.2f} of what it may be; {} bakes fail the check", over_bound, failing);
  result.note = "Worst of all generators, network -> stored.";
  return result;
}

}  // namespace

std::vector<StabilityCase> heldOutFamilyCases() {
  return {
      {"generator", "families that were never trained on",
       "every generator's theta is finite, no stage of the bake makes it worse, and the error of what a bake stores is at most "
       "the threshold tau, or 1.01 times what one constant does at best in the place of the whole network or field",
       StabilityDepth::brief, true, measureFamilies}};
}

}  // namespace nlg
