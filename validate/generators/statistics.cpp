#include "validate/generators/statistics.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

// A place between two order statistics of a list of `count`.
struct Place {
  uint64_t rank;  // of the lower one
  double upper;   // share of the upper one
};

Place placeOf(double share, uint64_t count) {
  const double position = share * static_cast<double>(count - 1);
  const auto rank = static_cast<uint64_t>(position);
  return {rank, position - static_cast<double>(rank)};
}

}  // namespace

double mean(const std::vector<double>& values) {
  if (values.empty()) return 0.0;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double quantile(std::vector<double>& values, double share) {
  if (values.empty()) return 0.0;
  const double position = share * static_cast<double>(values.size() - 1);
  const auto low = static_cast<size_t>(position);
  std::nth_element(values.begin(), values.begin() + low, values.end());
  const double below = values[low];
  if (low + 1 == values.size()) return below;
  const double above = *std::min_element(values.begin() + low + 1, values.end());
  return below + (position - static_cast<double>(low)) * (above - below);
}

Quantiles quantiles(std::vector<double> values) {
  Quantiles result;
  result.count = values.size();
  if (values.empty()) return result;
  result.mean = mean(values);
  result.worst = *std::max_element(values.begin(), values.end());
  result.median = quantile(values, 0.5);
  result.p95 = quantile(values, 0.95);
  result.p99 = quantile(values, 0.99);
  return result;
}

void PooledMagnitudes::add(double value) {
  const double magnitude = std::fabs(value);
  ++bins_[static_cast<size_t>(std::min<double>(kBinCount - 1, magnitude * 2048.0))];
  ++count_;
  sum_ += static_cast<uint64_t>(std::llround(std::min(magnitude, 16.0) * 0x1p30));
}

void PooledMagnitudes::add(const PooledMagnitudes& other) {
  for (int i = 0; i < kBinCount; ++i) bins_[i] += other.bins_[i];
  count_ += other.count_;
  sum_ += other.sum_;
}

double PooledMagnitudes::quantile(double share) const {
  uint64_t below = 0;
  for (int i = 0; i < kBinCount; ++i) {
    below += bins_[i];
    if (static_cast<double>(below) >= share * static_cast<double>(count_)) return count_ > 0 ? (i + 1) / 2048.0 : 0.0;
  }
  return kBinCount / 2048.0;
}

SceneBootstrap::SceneBootstrap(const std::vector<uint32_t>& scene_of_value, const BootstrapOptions& options)
    : options_(options), count_(scene_of_value.size()) {
  std::map<uint32_t, std::vector<uint32_t>> by_scene;
  for (uint32_t i = 0; i < count_; ++i) by_scene[scene_of_value[i]].push_back(i);
  std::vector<const std::vector<uint32_t>*> scenes;
  for (const auto& [scene, values] : by_scene) scenes.push_back(&values);
  Random random(options.seed);
  draws_.resize(static_cast<size_t>(options.resamples) * count_);
  for (size_t r = 0; r < draws_.size(); r += count_) {
    for (size_t draw = 0; draw < scenes.size(); ++draw) {
      const std::vector<uint32_t>& values = *scenes[random.below(static_cast<uint32_t>(scenes.size()))];
      for (size_t i = 0; i < values.size(); ++i) ++draws_[r + values[random.below(static_cast<uint32_t>(values.size()))]];
    }
  }
}

Interval SceneBootstrap::interval(double value, std::vector<double> resampled) const {
  const double tail = 0.5 * (1.0 - options_.confidence);
  return {value, quantile(resampled, tail), quantile(resampled, 1.0 - tail)};
}

Interval SceneBootstrap::mean(const std::vector<double>& values) const {
  return ofMeans({&values}, [](const std::vector<double>& means) { return means.front(); });
}

Interval SceneBootstrap::ofMeans(const std::vector<const std::vector<double>*>& lists,
                                 const std::function<double(const std::vector<double>&)>& figure) const {
  std::vector<double> means;
  for (const std::vector<double>* list : lists) means.push_back(nlg::mean(*list));
  const double value = figure(means);
  std::vector<double> resampled;
  for (int r = 0; count_ > 0 && r < options_.resamples; ++r) {
    const uint16_t* const drawn = draws(r);
    const double count = std::accumulate(drawn, drawn + count_, 0.0);
    for (size_t n = 0; n < lists.size(); ++n)
      means[n] = std::inner_product(drawn, drawn + count_, lists[n]->begin(), 0.0) / count;
    resampled.push_back(figure(means));
  }
  return interval(value, std::move(resampled));
}

std::vector<Interval> SceneBootstrap::quantiles(const std::vector<double>& values, const std::vector<double>& shares) const {
  std::vector<Interval> result;
  std::vector<double> copy = values;
  for (const double share : shares) {
    const double value = quantile(copy, share);
    result.push_back({value, value, value});
  }
  // sorted once for all resamples: each then counts how often every value was drawn
  std::vector<uint32_t> order(values.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return values[a] < values[b]; });

  std::vector<std::vector<double>> resampled(shares.size());
  for (int r = 0; count_ > 0 && r < options_.resamples; ++r) {
    const uint64_t count = std::accumulate(draws(r), draws(r) + count_, uint64_t{0});
    size_t at = 0;
    uint64_t below = 0;  // values of the resample up to and with order[at - 1]
    const auto valueAt = [&](uint64_t rank) {
      while (below <= rank) below += draws(r)[order[at++]];
      return values[order[at - 1]];
    };
    for (size_t q = 0; q < shares.size(); ++q) {
      const Place place = placeOf(shares[q], count);
      const double lower = valueAt(place.rank);
      // the scan goes on from here, and never back: shares rise
      const double upper = place.upper > 0.0 ? valueAt(place.rank + 1) : lower;
      resampled[q].push_back(lower + place.upper * (upper - lower));
    }
  }
  for (size_t q = 0; q < shares.size(); ++q) result[q] = interval(result[q].value, std::move(resampled[q]));
  return result;
}

}  // namespace nlg
