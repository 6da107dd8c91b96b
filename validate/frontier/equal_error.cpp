#include "validate/frontier/equal_error.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "validate/errors/statistics.h"

namespace nlg {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

struct Mean {
  double us = 0.0, rmse = 0.0;
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

struct Comparison {
  Mean own;
  Reach rival;
};

// means   of time and RMSE in turn: own, then all rivals
Comparison compare(const std::vector<double>& means, const std::vector<TimedPoint>& rivals) {
  Comparison comparison{{means[0], means[1]}, {}};
  std::vector<Mean> of_rivals;
  for (size_t i = 2; i < means.size(); i += 2) of_rivals.push_back({means[i], means[i + 1]});
  for (size_t begin = 0, end = 0; begin < rivals.size(); begin = end) {
    while (end < rivals.size() && rivals[end].family == rivals[begin].family) ++end;
    const Reach reach = reachOf(of_rivals, begin, end, comparison.own.rmse);
    if (reach.us < comparison.rival.us) comparison.rival = reach;
  }
  return comparison;
}

}  // namespace

EqualError compareAtEqualError(const TimedPoint& own, const std::vector<TimedPoint>& rivals, const SceneBootstrap& bootstrap) {
  std::vector<const std::vector<double>*> lists = {&own.us, &own.rmse};
  for (const TimedPoint& rival : rivals) lists.insert(lists.end(), {&rival.us, &rival.rmse});
  std::vector<double> means;
  for (const std::vector<double>* list : lists) means.push_back(mean(*list));
  const Comparison comparison = compare(means, rivals);
  const Reach& rival = comparison.rival;
  EqualError equal;
  equal.time_us = comparison.own.us;
  equal.rmse_mean = comparison.own.rmse;
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
  const Interval ratio = bootstrap.ofMeans(lists, [&](const std::vector<double>& resampled) {
    const Comparison one = compare(resampled, rivals);
    return one.rival.us / one.own.us;
  });
  equal.ratio = Ratio{ratio.value, std::isfinite(ratio.low) ? ratio.low : ratio.value, std::nullopt};
  if (std::isfinite(ratio.high)) equal.ratio->high = ratio.high;
  return equal;
}

}  // namespace nlg
