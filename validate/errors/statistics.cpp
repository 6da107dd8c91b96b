#include "validate/errors/statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace nlg {

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

}  // namespace nlg
