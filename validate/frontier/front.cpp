#include "validate/frontier/front.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace nlg {
namespace {

std::vector<size_t> byTime(const std::vector<FrontPoint>& points, const std::vector<size_t>& chosen) {
  std::vector<size_t> order = chosen;
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return points[a].us < points[b].us; });
  return order;
}

// Counts as equal: the larger is no more than a share above the smaller.
bool equal(double a, double b, double tolerance) { return std::max(a, b) <= std::min(a, b) * (1.0 + tolerance); }

std::vector<size_t> unbeaten(const std::vector<FrontPoint>& points, const FrontTolerances& tolerances) {
  std::vector<size_t> left;
  for (size_t a = 0; a < points.size(); ++a) {
    const auto beats = [&](const FrontPoint& b) {
      return b.may_be_member && b.us <= points[a].us * (1.0 + tolerances.time) &&
             b.error * (1.0 + tolerances.error) < points[a].error;
    };
    if (points[a].may_be_member && std::none_of(points.begin(), points.end(), beats)) left.push_back(a);
  }
  return left;
}

// Three digits, microseconds or milliseconds.
std::string timeText(double us) { return us < 1000.0 ? fmt::format("{:.3g} µs", us) : fmt::format("{:.3g} ms", us / 1000.0); }

constexpr double kNever = std::numeric_limits<double>::infinity();

struct Mean {
  double us = 0.0, error = 0.0;
};

// When a family reaches an error.
struct Reach {
  double us = kNever;
  size_t before = 0, at = 0;     // the budgets between which it does, as indices into all baselines; equal: the first is below it
  double share = 0.0;            // of the way from one to the other, in logarithms of the error
  bool is_only_a_bound = false;  // the first budget that counts is already below the error
};

// means   of all baselines
// begin, end   of one family
Reach reachOf(const std::vector<Mean>& means, size_t begin, size_t end, double error) {
  std::vector<size_t> order;
  for (size_t i = begin; i < end; ++i) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return means[a].us < means[b].us; });
  // from the fastest on, whatever is more accurate than all before it
  const Mean* last = nullptr;
  size_t last_at = 0;
  for (const size_t i : order) {
    const Mean& mean = means[i];
    if (last && mean.error >= last->error) continue;
    if (mean.error <= error) {
      if (!last) return {mean.us, i, i, 0.0, mean.error < error};
      const double share = std::log(last->error / error) / std::log(last->error / mean.error);
      return {last->us * std::pow(mean.us / last->us, share), last_at, i, share, false};
    }
    last = &mean;
    last_at = i;
  }
  return {};
}

struct Comparison {
  Mean own;
  Reach baseline;
};

// means   of time and error in turn: own, then all baselines
Comparison compare(const std::vector<double>& means, const std::vector<TimedPoint>& baselines) {
  Comparison comparison{{means[0], means[1]}, {}};
  std::vector<Mean> of_baselines;
  for (size_t i = 2; i < means.size(); i += 2) of_baselines.push_back({means[i], means[i + 1]});
  for (size_t begin = 0, end = 0; begin < baselines.size(); begin = end) {
    while (end < baselines.size() && baselines[end].family == baselines[begin].family) ++end;
    const Reach reach = reachOf(of_baselines, begin, end, comparison.own.error);
    if (reach.us < comparison.baseline.us) comparison.baseline = reach;
  }
  return comparison;
}

// By function.
std::vector<double> failsBetween(const TimedPoint& before, const TimedPoint& at, double share) {
  std::vector<double> fails;
  for (size_t i = 0; i < at.fails_check.size(); ++i) {
    fails.push_back((1.0 - share) * before.fails_check[i] + share * at.fails_check[i]);
  }
  return fails;
}

}  // namespace

std::vector<bool> frontMembers(const std::vector<FrontPoint>& points, const FrontTolerances& tolerances) {
  const std::vector<size_t> left = unbeaten(points, tolerances);
  std::vector<bool> members(points.size(), false);
  const FrontPoint* last = nullptr;
  for (const size_t a : byTime(points, left)) {
    if (last && points[a].error * (1.0 + tolerances.error) >= last->error) continue;
    last = &points[a];
    const size_t first = *std::find_if(left.begin(), left.end(), [&](size_t b) {
      return equal(points[a].us, points[b].us, tolerances.time) && equal(points[a].error, points[b].error, tolerances.error);
    });
    members[first] = true;
  }
  return members;
}

std::string frontSentence(const std::string& population, const std::vector<FrontPoint>& points, const std::vector<bool>& members,
                          const std::vector<std::string>& names) {
  std::vector<size_t> chosen;
  for (size_t i = 0; i < points.size(); ++i) {
    if (members[i]) chosen.push_back(i);
  }
  if (chosen.empty())
    return "Over " + population + " nothing has a smaller mean blend RMSE than the bare tent, which takes no time.";
  const auto text = [&](size_t i, const char* what) {
    return fmt::format("{} ({}, {}{:.3g})", names[i], timeText(points[i].us), what, points[i].error);
  };
  const std::vector<size_t> order = byTime(points, chosen);
  const std::string begin = fmt::format(
      "Of {} ways from a function to its θ, {} beaten by none in both time and mean blend RMSE over {}: ", points.size(),
      order.size() == 1 ? "one is" : fmt::format("{} are", order.size()), population);
  if (order.size() == 1) return begin + text(order.front(), "mean blend RMSE ") + '.';
  return begin + "from " + text(order.front(), "mean blend RMSE ") + " to " + text(order.back(), "") + '.';
}

EqualError compareAtEqualError(const TimedPoint& own, const std::vector<TimedPoint>& baselines, const SceneBootstrap& bootstrap) {
  // own and baselines' times and errors in one list, so that the bootstrap resamples scenes of all together
  std::vector<const std::vector<double>*> lists = {&own.us, &own.blend_rmse};
  for (const TimedPoint& baseline : baselines) lists.insert(lists.end(), {&baseline.us, &baseline.blend_rmse});
  std::vector<double> means;
  for (const std::vector<double>* list : lists) means.push_back(mean(*list));
  const Comparison comparison = compare(means, baselines);
  const Reach& baseline = comparison.baseline;
  EqualError equal;
  equal.time_us = comparison.own.us;
  equal.blend_rmse_mean = comparison.own.error;
  equal.share_failing = bootstrap.mean(own.fails_check);
  // no budget reaches the error: the ratio is unbounded, and its longest fit is a lower bound of the time
  if (baseline.us == kNever) {
    equal.reason = "no direct fit reaches this error";
    for (const TimedPoint& one : baselines) equal.longest_us = std::max(equal.longest_us.value_or(0.0), mean(one.us));
    return equal;
  }
  // even the shortest fit is better: the time at this error is unknown
  if (baseline.is_only_a_bound) {
    equal.reason = "the error of the shortest fit, " + baselines[baseline.at].label + ", is already below this one";
    return equal;
  }
  // between two budgets time is interpolated at the own error
  equal.baseline = baseline.before == baseline.at
                       ? baselines[baseline.at].label
                       : "between " + baselines[baseline.before].label + " and " + baselines[baseline.at].label;
  equal.baseline_us = baseline.us;
  equal.baseline_share_failing = bootstrap.mean(failsBetween(baselines[baseline.before], baselines[baseline.at], baseline.share));
  // intervals over scenes; a resampling in which no fit reaches the error leaves the upper bound open
  const Interval ratio = bootstrap.ofMeans(lists, [&](const std::vector<double>& resampled) {
    const Comparison one = compare(resampled, baselines);
    return one.baseline.us / one.own.us;
  });
  equal.ratio = Ratio{ratio.value, std::isfinite(ratio.low) ? ratio.low : ratio.value, std::nullopt};
  if (std::isfinite(ratio.high)) equal.ratio->high = ratio.high;
  return equal;
}

}  // namespace nlg
