#include "validate/compare/significance.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <unsupported/Eigen/SpecialFunctions>

namespace nlg {

double studentChance(double t, double degrees_of_freedom) {
  const double squared = t * t;
  if (std::isinf(squared)) return 0.0;
  // Abramowitz and Stegun 26.7.1
  return Eigen::numext::betainc(0.5 * degrees_of_freedom, 0.5, degrees_of_freedom / (degrees_of_freedom + squared));
}

double signChance(uint64_t risen, uint64_t fallen) {
  const auto fewer = static_cast<double>(std::min(risen, fallen)), more = static_cast<double>(std::max(risen, fallen));
  if (fewer == more) return 1.0;
  // at most `fewer` heads of fewer + more fair coins, Abramowitz and Stegun 26.5.24
  return std::min(1.0, 2.0 * Eigen::numext::betainc(more, fewer + 1.0, 0.5));
}

std::vector<bool> beyondChance(const std::vector<double>& chances, double level) {
  std::vector<size_t> order(chances.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return chances[a] < chances[b]; });
  std::vector<bool> beyond(chances.size(), false);
  for (size_t i = 0; i < order.size(); ++i) {
    if (chances[order[i]] > level / static_cast<double>(order.size() - i)) break;
    beyond[order[i]] = true;
  }
  return beyond;
}

}  // namespace nlg
