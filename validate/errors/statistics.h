// Figures over many functions: quantiles, and a histogram for what is pooled over millions of points.
#pragma once

#include <array>
#include <cstdint>
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

}  // namespace nlg
