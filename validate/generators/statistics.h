// Statistics over many functions: quantiles, and a histogram for values pooled over millions of points.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace nlg {

struct Quantiles {
  uint64_t count = 0;
  double median = 0, mean = 0, p95 = 0, p99 = 0, worst = 0;
};

// 0 for an empty list.
double mean(const std::vector<double>& values);

// Quantiles by linear interpolation between order statistics; zeros when there is no value. Values must be finite.
Quantiles quantiles(std::vector<double> values);

// The value at a share of the sorted list, whose order it may change; 0 <= share <= 1; 0 for an empty list.
double quantile(std::vector<double>& values, double share);

// Mean and quantiles of magnitudes pooled over points, in constant memory: bins of 1/2048 up to 2, larger ones in the last bin. The
// order in which values come changes no bit: sums are whole numbers of 2^-30, and what is above 16 counts as 16.
class PooledMagnitudes {
 public:
  void add(double value);
  void add(const std::vector<double>& values) {
    for (const double value : values) add(value);
  }
  void add(const PooledMagnitudes& other);
  double mean() const { return count_ > 0 ? static_cast<double>(sum_) * 0x1p-30 / static_cast<double>(count_) : 0.0; }
  double quantile(double share) const;  // upper edge of the bin

 private:
  static constexpr int kBinCount = 4096;
  std::array<uint64_t, kBinCount> bins_{};
  uint64_t count_ = 0, sum_ = 0;
};

// Intervals by bootstrap over scenes and functions: how far a figure would move if others had been held out.
//
// Functions of one scene resemble each other, so scenes are drawn first, with replacement, and then of each drawn scene as many functions
// as it has, with replacement too (Davison & Hinkley 1997, section 3.8). The interval reaches from the 2.5th to the 97.5th percentile of
// the resamples' figures. A simulation of 24 scenes (bootstrap_test.cpp) says how far to trust it. The interval of a 95th percentile hangs
// on the few highest scenes; read it as a lower bound of the uncertainty. One scene says nothing of others: its interval is over functions
// alone.

struct BootstrapOptions {
  int resamples = 1000;
  double confidence = 0.95;
  uint64_t seed = 1;
};

struct Interval {
  double value = 0.0, low = 0.0, high = 0.0;  // low <= value <= high, but for figures that resampling shifts to one side
};

class SceneBootstrap {
 public:
  // scene_of_value   of every value of the lists to come; scenes without any value are not drawn
  explicit SceneBootstrap(const std::vector<uint32_t>& scene_of_value, const BootstrapOptions& options = {});

  // Zeros for an empty list.
  // values   one a scene_of_value, in their order; finite
  Interval mean(const std::vector<double>& values) const;
  // Linear between order statistics, as quantile() is.
  // shares    rising, in [0, 1]
  // returns   one interval a share
  std::vector<Interval> quantiles(const std::vector<double>& values, const std::vector<double>& shares) const;
  // Any figure of several lists' means.
  // lists    each as `values` of mean
  // figure   of the means of one resample, in the order of the lists; may be infinite, and so may then be an end of the interval
  Interval ofMeans(const std::vector<const std::vector<double>*>& lists,
                   const std::function<double(const std::vector<double>&)>& figure) const;

 private:
  Interval interval(double value, std::vector<double> resampled) const;
  const uint16_t* draws(int resample) const { return &draws_[static_cast<size_t>(resample) * count_]; }

  BootstrapOptions options_;
  size_t count_;                 // of values
  std::vector<uint16_t> draws_;  // by resample and value: how often it was drawn
};

}  // namespace nlg
