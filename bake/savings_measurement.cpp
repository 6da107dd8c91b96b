#include "bake/savings_measurement.h"

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
  LeftOut left_out;
  BakeOptions options;
  std::vector<Generator> generators;
  bool leaves_out = false;  // it leaves out what the bake does not yet; otherwise it does what the bake leaves out

  int sign() const { return leaves_out ? -1 : 1; }  // of what it takes more
};

struct Result {
  LightGrid grid;
  double seconds = 0.0;
  int64_t bytes = 0;
};

class SavingsMeasurement {
 public:
  SavingsMeasurement(const BakeInputs& inputs, const BakeStatistics& statistics, std::vector<Saving>* savings)
      : inputs_(inputs), savings_(*savings) {
    as_asked_.generators = inputs.generators;
    as_asked_.options = inputs.options;
    addVariants(statistics);
  }

  void run(int rounds) {
    std::vector<std::vector<double>> saved(variants_.size());
    std::vector<double> ray_seconds;
    double bake_noise = 0.0, ray_noise = 0.0;
    Progress progress("bakes for the table of savings",
                      static_cast<int64_t>(rounds) * static_cast<int64_t>(variants_.size() + 2));
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
        if (round == 0) compare(base, other, variant.sign(), findSaving(savings_, variant.what));
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
    for (size_t v = 0; v < variants_.size(); ++v) setSeconds(saved[v], bake_noise, findSaving(savings_, variants_[v].what));
    setSeconds(ray_seconds, ray_noise, findSaving(savings_, saving::kSolidRays));
  }

 private:
  // One for every line that holds something.
  Variant* add(const char* what, bool leaves_out = false) {
    const Saving* saving = findSaving(savings_, what);
    if (saving == nullptr || !saving->left_out || saving->count == 0) return nullptr;
    variants_.push_back(as_asked_);
    variants_.back().what = what;
    variants_.back().leaves_out = leaves_out;
    return &variants_.back();
  }

  void addVariants(const BakeStatistics& statistics) {
    if (Variant* v = add(saving::kFreeSpace)) v->left_out.free_space = false;
    if (Variant* v = add(saving::kInSolid)) v->left_out.in_solid = false;
    if (Variant* v = add(saving::kEmpty)) v->left_out.empty = false;
    if (Variant* v = add(saving::kDuplicates)) v->left_out.duplicates = false;
    if (Variant* v = add(saving::kAllProbes)) {
      v->left_out = {false, false, false, false};
      v->options.policy.bare_tent_rmse = 0.0;
    }
    if (Variant* v = add(saving::kLargestTheta)) v->generators = {inputs_.generators.back()};
    if (Variant* v = add(saving::kBareTent)) v->options.policy.bare_tent_rmse = 0.0;
    if (Variant* v = add(saving::kPassingTent, true)) v->options.policy.bare_tent_rmse = inputs_.options.policy.check().tau_rmse;
    if (Variant* v = add(saving::kGoodTheta)) v->options.policy.stages.good_rmse = 0.0;
    const std::vector<uint64_t> functions = statistics.chosen(inputs_.generators.size());
    std::vector<Generator> chosen;
    for (size_t g = 0; g < inputs_.generators.size(); ++g) {
      if (functions[g] > 0) chosen.push_back(inputs_.generators[g]);
    }
    if (!chosen.empty()) {
      if (Variant* v = add(saving::kNeverChosenGenerators, true)) v->generators = chosen;
    }
    const bool is_rounded = as_asked_.options.policy.theta_precision != ThetaPrecision::float32;
    if (Variant* v = add(saving::kThetaBits, !is_rounded)) {
      v->options.policy.theta_precision = is_rounded ? ThetaPrecision::float32 : ThetaPrecision::float16;
    }
  }

  Result bake(const Variant& variant) const {
    const double start = processorSeconds();
    Bake bake = bakeScene(inputs_.scene, variant.generators, variant.options, inputs_.spool_folder, variant.left_out);
    Result result{std::move(bake.grid), processorSeconds() - start};
    std::string bytes;
    const FileResult written = serializeLightGrid(result.grid, {variant.options.policy.theta_precision}, {}, &bytes);
    if (!written.ok())
      throw NumericalError("bake: light grid, " + variant.what + ": " + written.detail + ": no number that the file can hold");
    result.bytes = static_cast<int64_t>(bytes.size());
    return result;
  }

  // By the rays that tell probes in air from those in solid. Disputed places do not count: most of them lie within flipped or
  // self-intersecting solids, or just outside an open hull.
  std::vector<PositionM> placesInAir(const LightGrid& grid) const {
    const SupportVisibility visibility(inputs_.scene.rays, inputs_.scene.links);
    const glm::dvec3& origin_m = inputs_.scene.source.scene.origin_m;
    return lookUpPlaces(grid.tree, kLookUps, 1, [&](const PositionM& world) {
      const SolidVote vote = visibility.voteAt(glm::dvec3(world[0], world[1], world[2]) - origin_m);
      return !vote.solid() && !vote.disputed();
    });
  }

  void compare(const Result& base, const Result& other, int sign, Saving* saving) const {
    saving->bytes_saved = sign * (other.bytes - base.bytes);
    const LookUpDifference difference = lookUpDifference(base.grid, other.grid, places_);
    if (difference.look_ups == 0) {
      saving->note += "; no place in air to compare look-ups at";
      return;
    }
    saving->same_result = difference.changed == 0;
    if (difference.changed == 0) {
      saving->note += fmt::format("; the same look-ups at {} places in air", difference.look_ups);
    } else {
      saving->note += fmt::format("; largest difference of a weight {:.2g}, mean {:.2g}, over look-ups at {} places in air",
                                  difference.largest, difference.mean, difference.look_ups);
    }
  }

  static void setSeconds(std::vector<double> seconds, double noise, Saving* saving) {
    std::sort(seconds.begin(), seconds.end());
    const size_t middle = seconds.size() / 2;
    const double median = seconds.size() % 2 == 1 ? seconds[middle] : 0.5 * (seconds[middle - 1] + seconds[middle]);
    saving->seconds_saved = median;
    saving->seconds_noise = noise;
    if (seconds.size() > 1)
      saving->note += fmt::format("; {:.3f} to {:.3f} s in {} rounds", seconds.front(), seconds.back(), seconds.size());
    saving->note +=
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
  std::vector<Saving>& savings_;
  Variant as_asked_;
  std::vector<Variant> variants_;
  std::vector<PositionM> places_;  // where grids are compared
};

}  // namespace

void measureSavings(const BakeInputs& inputs, const BakeStatistics& statistics, int rounds, std::vector<Saving>* savings) {
  SavingsMeasurement(inputs, statistics, savings).run(rounds);
}

}  // namespace nlg
