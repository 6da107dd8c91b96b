#include "validate/frontier/equal_error.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kTail = 0.025;

struct Mean {
  double us = 0.0, rmse = 0.0;
};

// Sums of a point by scene, so that a draw of scenes takes no second look at functions.
struct SceneSums {
  std::vector<double> us, rmse;

  SceneSums(const TimedPoint& point, const std::vector<uint32_t>& scene, size_t scene_count)
      : us(scene_count, 0.0), rmse(scene_count, 0.0) {
    for (size_t i = 0; i < scene.size(); ++i) {
      us[scene[i]] += point.us[i];
      rmse[scene[i]] += point.rmse[i];
    }
  }

  // times   how often each scene was drawn
  Mean mean(const std::vector<int>& times, double function_count) const {
    Mean sum;
    for (size_t s = 0; s < times.size(); ++s) {
      sum.us += times[s] * us[s];
      sum.rmse += times[s] * rmse[s];
    }
    return {sum.us / function_count, sum.rmse / function_count};
  }
};

// When a family reaches an error.
struct Reach {
  double us = kNever;
  size_t before = 0, at = 0;     // the budgets between which it does, as indices into all rivals; equal: the first is below it
  bool is_only_a_bound = false;  // the first budget that counts is already below the error
};

// means   of all rivals
// begin, end   of one family
Reach reachOf(const std::vector<Mean>& means, size_t begin, size_t end, double rmse) {
  std::vector<size_t> order;
  for (size_t i = begin; i < end; ++i) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return means[a].us < means[b].us; });
  // from the fastest on, whatever is more accurate than all before it
  const Mean* last = nullptr;
  size_t last_at = 0;
  for (const size_t i : order) {
    const Mean& mean = means[i];
    if (last && mean.rmse >= last->rmse) continue;
    if (mean.rmse <= rmse) {
      if (!last) return {mean.us, i, i, mean.rmse < rmse};
      const double share = std::log(last->rmse / rmse) / std::log(last->rmse / mean.rmse);
      return {last->us * std::pow(mean.us / last->us, share), last_at, i, false};
    }
    last = &mean;
    last_at = i;
  }
  return {};
}

class Comparison {
 public:
  Comparison(const TimedPoint& own, const std::vector<TimedPoint>& rivals, const std::vector<uint32_t>& scene, size_t scene_count)
      : own_(own, scene, scene_count), functions_(scene_count, 0) {
    for (const TimedPoint& rival : rivals) rivals_.emplace_back(rival, scene, scene_count);
    for (size_t i = 0; i < rivals.size(); ++i) {
      if (i == 0 || rivals[i].family != rivals[i - 1].family) family_begin_.push_back(i);
    }
    for (const uint32_t s : scene) ++functions_[s];
    for (uint32_t s = 0; s < scene_count; ++s) {
      if (functions_[s] > 0) drawn_.push_back(s);
    }
  }

  struct Result {
    Mean own;
    Reach rival;
  };

  // times   how often each scene counts; some function must
  Result compare(const std::vector<int>& times) const {
    double count = 0.0;
    for (size_t s = 0; s < times.size(); ++s) count += static_cast<double>(times[s]) * functions_[s];
    std::vector<Mean> means;
    for (const SceneSums& rival : rivals_) means.push_back(rival.mean(times, count));
    Result result{own_.mean(times, count), {}};
    for (size_t f = 0; f < family_begin_.size(); ++f) {
      const size_t end = f + 1 < family_begin_.size() ? family_begin_[f + 1] : rivals_.size();
      const Reach reach = reachOf(means, family_begin_[f], end, result.own.rmse);
      if (reach.us < result.rival.us) result.rival = reach;
    }
    return result;
  }

  std::vector<double> drawRatios(int draws, uint64_t seed) const {
    Random random(seed);
    const auto scene_count = static_cast<uint32_t>(drawn_.size());
    std::vector<double> ratios;
    for (int draw = 0; draw < draws; ++draw) {
      std::vector<int> times(functions_.size(), 0);
      for (uint32_t n = 0; n < scene_count; ++n) ++times[drawn_[random.below(scene_count)]];
      const Result result = compare(times);
      ratios.push_back(result.rival.us / result.own.us);
    }
    std::sort(ratios.begin(), ratios.end());
    return ratios;
  }

  std::vector<int> once() const { return std::vector<int>(functions_.size(), 1); }

 private:
  SceneSums own_;
  std::vector<SceneSums> rivals_;
  std::vector<size_t> family_begin_;
  std::vector<int> functions_;   // by scene
  std::vector<uint32_t> drawn_;  // scenes that have some
};

}  // namespace

EqualError compareAtEqualError(const TimedPoint& own, const std::vector<TimedPoint>& rivals, const std::vector<uint32_t>& scene,
                               size_t scene_count, int draws, uint64_t seed) {
  const Comparison comparison(own, rivals, scene, scene_count);
  const Comparison::Result result = comparison.compare(comparison.once());
  EqualError equal;
  equal.time_us = result.own.us;
  equal.rmse_mean = result.own.rmse;
  const Reach& rival = result.rival;
  if (rival.us == kNever) {
    equal.reason = "no direct fit reaches this error";
    return equal;
  }
  if (rival.is_only_a_bound) {
    equal.reason = "the error of the shortest fit, " + rivals[rival.at].label + ", is already below this one";
    return equal;
  }
  equal.rival = rival.before == rival.at ? rivals[rival.at].label
                                         : "between " + rivals[rival.before].label + " and " + rivals[rival.at].label;
  equal.rival_us = rival.us;
  const std::vector<double> ratios = comparison.drawRatios(draws, seed);
  Ratio ratio{rival.us / result.own.us, 0.0, std::nullopt};
  const auto last = static_cast<double>(ratios.size() - 1);
  ratio.low = ratios[static_cast<size_t>(std::floor(kTail * last))];
  const double high = ratios[static_cast<size_t>(std::ceil((1.0 - kTail) * last))];
  if (high < kNever) ratio.high = high;
  equal.ratio = ratio;
  return equal;
}

}  // namespace nlg
