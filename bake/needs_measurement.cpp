#include "bake/needs_measurement.h"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>

#include "bake/look_up_difference.h"
#include "datagen/visibility/support_visibility.h"
#include "tool/error.h"
#include "tool/progress.h"

namespace nlg {
namespace {

constexpr uint64_t kLookUps = 20000;

// Of the processor, all threads together: what a busy machine does to the clock is not a saving.
double processorSeconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// A bake that differs from the one asked for by one saving.
struct Variant {
  std::string what;  // the line that it measures
  BakeSavings savings;
  std::vector<Generator> generators;
  ThetaPrecision theta_precision = ThetaPrecision::float32;
  bool leaves_out = false;  // it leaves out what the bake does not yet; otherwise it does what the bake leaves out
};

struct Result {
  LightGrid grid;
  double seconds = 0.0;
  int64_t bytes = 0;
};

class NeedsMeasurement {
 public:
  NeedsMeasurement(const BakeInputs& inputs, const BakeStatistics& statistics, std::vector<Need>* needs)
      : inputs_(inputs), needs_(*needs) {
    as_asked_.generators = inputs.generators;
    as_asked_.theta_precision = inputs.theta_precision;
    addVariants(statistics);
  }

  void run(int rounds) {
    std::vector<std::vector<double>> saved(variants_.size());
    std::vector<double> ray_seconds;
    Progress progress("bakes for the table of needs", static_cast<int64_t>(rounds) * static_cast<int64_t>(variants_.size() + 1));
    int64_t done = 0;
    for (int round = 0; round < rounds; ++round) {
      const Result base = bake(as_asked_);
      progress.update(++done);
      for (size_t v = 0; v < variants_.size(); ++v) {
        const Result other = bake(variants_[v]);
        const int sign = variants_[v].leaves_out ? -1 : 1;
        saved[v].push_back(sign * (other.seconds - base.seconds));
        progress.update(++done);
        if (round == 0) compare(base, other, sign, findNeed(needs_, variants_[v].what));
      }
      ray_seconds.push_back(solidRaySeconds(base.grid));
    }
    for (size_t v = 0; v < variants_.size(); ++v) setSeconds(saved[v], findNeed(needs_, variants_[v].what));
    setSeconds(ray_seconds, findNeed(needs_, need::kSolidRays));
  }

 private:
  // One for every line that holds something.
  Variant* add(const char* what, bool leaves_out = false) {
    const Need* need = findNeed(needs_, what);
    if (need == nullptr || !need->left_out || need->count == 0) return nullptr;
    variants_.push_back(as_asked_);
    variants_.back().what = what;
    variants_.back().leaves_out = leaves_out;
    return &variants_.back();
  }

  void addVariants(const BakeStatistics& statistics) {
    if (Variant* v = add(need::kFreeSpace)) v->savings.free_space = false;
    if (Variant* v = add(need::kInSolid)) v->savings.in_solid = false;
    if (Variant* v = add(need::kEmpty)) v->savings.empty = false;
    if (Variant* v = add(need::kDuplicates)) v->savings.duplicates = false;
    if (Variant* v = add(need::kAllProbes)) {
      v->savings.free_space = v->savings.in_solid = v->savings.empty = v->savings.duplicates = v->savings.bare_tent = false;
    }
    if (Variant* v = add(need::kLargerGenerators)) v->savings.larger_generators = false;
    if (Variant* v = add(need::kLargestTheta)) v->generators = {inputs_.generators.back()};
    if (Variant* v = add(need::kBareTent)) v->savings.bare_tent = false;
    if (Variant* v = add(need::kPassingTent, true)) v->savings.passing_tent = true;
    if (Variant* v = add(need::kCorrection)) v->savings.correction = false;
    if (Variant* v = add(need::kRefinement)) v->savings.refinement = false;
    std::vector<Generator> chosen;
    for (size_t g = 0; g < inputs_.generators.size(); ++g) {
      if (statistics.chosen[g] > 0) chosen.push_back(inputs_.generators[g]);
    }
    if (!chosen.empty()) {
      if (Variant* v = add(need::kNeverChosenGenerators, true)) v->generators = chosen;
    }
    const bool is_half = as_asked_.theta_precision == ThetaPrecision::float16;
    if (Variant* v = add(need::kHalfTheta, !is_half)) {
      v->theta_precision = is_half ? ThetaPrecision::float32 : ThetaPrecision::float16;
    }
  }

  Result bake(const Variant& variant) const {
    const double start = processorSeconds();
    Bake bake = bakeScene(inputs_.scene, variant.generators, inputs_.options, variant.theta_precision, inputs_.spool_folder,
                          variant.savings);
    Result result{std::move(bake.grid), processorSeconds() - start};
    std::string bytes;
    const WeightsResult written = serializeLightGrid(result.grid, variant.theta_precision, {}, &bytes);
    if (!written.ok()) throw NumericalError("bake", "light grid, " + variant.what, written.detail, 0.0);
    result.bytes = static_cast<int64_t>(bytes.size());
    return result;
  }

  static void compare(const Result& base, const Result& other, int sign, Need* need) {
    const LookUpDifference difference = lookUpDifference(base.grid, other.grid, kLookUps, 1);
    need->bytes_saved = sign * (other.bytes - base.bytes);
    need->same_result = difference.none();
    if (difference.none()) return;
    need->note += fmt::format("; largest difference of a weight {:.2g}, mean {:.2g}, over {} look-ups", difference.largest,
                              difference.mean, difference.look_ups);
  }

  static void setSeconds(std::vector<double> seconds, Need* need) {
    std::sort(seconds.begin(), seconds.end());
    const size_t middle = seconds.size() / 2;
    need->seconds_saved = seconds.size() % 2 == 1 ? seconds[middle] : 0.5 * (seconds[middle - 1] + seconds[middle]);
    if (seconds.size() < 2) return;
    need->note += fmt::format("; {:.3f} to {:.3f} s in {} rounds", seconds.front(), seconds.back(), seconds.size());
  }

  double solidRaySeconds(const LightGrid& grid) const {
    const SupportVisibility visibility(inputs_.scene.rays, inputs_.scene.links);
    const double start = processorSeconds();
    for (size_t probe = 0; probe < grid.probe_function.size(); ++probe) {
      if (grid.probe_function[probe] != kFreeSpace) continue;
      const auto [x, y, z] = inputs_.scene.tree.probePosition(probe);
      visibility.voteAt({x, y, z});
    }
    return processorSeconds() - start;
  }

  const BakeInputs& inputs_;
  std::vector<Need>& needs_;
  Variant as_asked_;
  std::vector<Variant> variants_;
};

}  // namespace

void measureNeeds(const BakeInputs& inputs, const BakeStatistics& statistics, int rounds, std::vector<Need>* needs) {
  NeedsMeasurement(inputs, statistics, needs).run(rounds);
}

}  // namespace nlg
