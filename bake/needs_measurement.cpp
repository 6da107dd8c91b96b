#include "bake/needs_measurement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "bake/look_up_difference.h"
#include "datagen/visibility/support_visibility.h"
#include "tool/error.h"
#include "tool/progress.h"

namespace nlg {
namespace {

constexpr uint64_t kLookUps = 20000;  // places drawn; those in air count

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

  int sign() const { return leaves_out ? -1 : 1; }  // of what it takes more
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
    double bake_noise = 0.0, ray_noise = 0.0;
    Progress progress("bakes for the table of needs", static_cast<int64_t>(rounds) * static_cast<int64_t>(variants_.size() + 2));
    int64_t done = 0;
    for (int round = 0; round < rounds; ++round) {
      const Result base = bake(as_asked_);
      progress.update(++done);
      if (round == 0) places_ = placesInAir(base.grid);
      std::vector<double> seconds;
      for (const Variant& variant : variants_) {
        const Result other = bake(variant);
        seconds.push_back(other.seconds);
        progress.update(++done);
        if (round == 0) compare(base, other, variant.sign(), findNeed(needs_, variant.what));
      }
      // the same bake at both ends of the round: how far they are apart is what seconds are worth
      const double again = bake(as_asked_).seconds, as_asked = 0.5 * (base.seconds + again);
      progress.update(++done);
      bake_noise = std::max(bake_noise, std::abs(again - base.seconds));
      for (size_t v = 0; v < variants_.size(); ++v) saved[v].push_back(variants_[v].sign() * (seconds[v] - as_asked));
      const double rays = solidRaySeconds(base.grid), rays_again = solidRaySeconds(base.grid);
      ray_noise = std::max(ray_noise, std::abs(rays_again - rays));
      ray_seconds.push_back(0.5 * (rays + rays_again));
    }
    for (size_t v = 0; v < variants_.size(); ++v) setSeconds(saved[v], bake_noise, findNeed(needs_, variants_[v].what));
    setSeconds(ray_seconds, ray_noise, findNeed(needs_, need::kSolidRays));
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

  // The same test by rays that tells probes in air from those in solid.
  std::vector<PositionM> placesInAir(const LightGrid& grid) const {
    const SupportVisibility visibility(inputs_.scene.rays, inputs_.scene.links);
    const glm::dvec3& origin_m = inputs_.scene.source.scene.origin_m;
    return lookUpPlaces(grid.tree, kLookUps, 1, [&](const PositionM& world) {
      return !visibility.voteAt(glm::dvec3(world[0], world[1], world[2]) - origin_m).solid();
    });
  }

  void compare(const Result& base, const Result& other, int sign, Need* need) const {
    need->bytes_saved = sign * (other.bytes - base.bytes);
    const LookUpDifference difference = lookUpDifference(base.grid, other.grid, places_);
    if (difference.look_ups == 0) {
      need->note += "; no place in air to compare look-ups at";
      return;
    }
    need->same_result = difference.changed == 0;
    if (difference.changed == 0) {
      need->note += fmt::format("; the same look-ups at {} places in air", difference.look_ups);
    } else {
      need->note += fmt::format("; largest difference of a weight {:.2g}, mean {:.2g}, over look-ups at {} places in air",
                                difference.largest, difference.mean, difference.look_ups);
    }
  }

  static void setSeconds(std::vector<double> seconds, double noise, Need* need) {
    std::sort(seconds.begin(), seconds.end());
    const size_t middle = seconds.size() / 2;
    const double median = seconds.size() % 2 == 1 ? seconds[middle] : 0.5 * (seconds[middle - 1] + seconds[middle]);
    need->seconds_saved = median;
    need->seconds_noise = noise;
    if (seconds.size() > 1)
      need->note += fmt::format("; {:.3f} to {:.3f} s in {} rounds", seconds.front(), seconds.back(), seconds.size());
    need->note +=
        fmt::format("; {}the same twice is {}{:.3f} s apart",
                    std::abs(median) > noise ? "" : "no seconds beyond noise: ", seconds.size() > 1 ? "up to " : "", noise);
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
  std::vector<PositionM> places_;  // where grids are compared
};

}  // namespace

void measureNeeds(const BakeInputs& inputs, const BakeStatistics& statistics, int rounds, std::vector<Need>* needs) {
  NeedsMeasurement(inputs, statistics, needs).run(rounds);
}

}  // namespace nlg
