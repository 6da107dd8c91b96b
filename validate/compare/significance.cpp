#include "validate/compare/significance.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tool/error.h"

namespace nlg {
namespace {

// Lentz's evaluation of the continued fraction of the incomplete beta function, Abramowitz and Stegun 26.5.8; x below the mean.
double betaFraction(double a, double b, double x) {
  constexpr double kEnough = 1e-14, kNotZero = 1e-300;
  constexpr int kMostTerms = 1000000;  // some square roots of a and b are enough
  const auto kept = [](double value) { return std::fabs(value) < kNotZero ? kNotZero : value; };
  double c = 1.0, d = 1.0 / kept(1.0 - (a + b) * x / (a + 1.0)), fraction = d, change = 0.0;
  int term = 1;
  for (; std::fabs(change - 1.0) > kEnough && term < kMostTerms; ++term) {
    const double m = term;
    const double even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
    d = 1.0 / kept(1.0 + even * d);
    c = kept(1.0 + even / c);
    fraction *= d * c;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
    d = 1.0 / kept(1.0 + odd * d);
    c = kept(1.0 + odd / c);
    change = d * c;
    fraction *= change;
  }
  NLG_CHECK(term, <, kMostTerms);
  return fraction;
}

// The regularised incomplete beta function I_x(a, b); y = 1 - x is given apart, for it may be below what x can hold.
double incompleteBeta(double a, double b, double x, double y) {
  if (x <= 0.0) return 0.0;
  if (y <= 0.0) return 1.0;
  if (x > (a + 1.0) / (a + b + 2.0)) return 1.0 - incompleteBeta(b, a, y, x);
  const double log_front = a * std::log(x) + b * std::log(y) + std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b);
  return std::exp(log_front) * betaFraction(a, b, x) / a;
}

}  // namespace

double studentChance(double t, double degrees_of_freedom) {
  const double squared = t * t;
  if (std::isinf(squared)) return 0.0;
  const double sum = degrees_of_freedom + squared;
  return incompleteBeta(0.5 * degrees_of_freedom, 0.5, degrees_of_freedom / sum, squared / sum);
}

double signChance(uint64_t risen, uint64_t fallen) {
  const auto fewer = static_cast<double>(std::min(risen, fallen)), more = static_cast<double>(std::max(risen, fallen));
  if (fewer == more) return 1.0;
  // at most `fewer` heads of fewer + more fair coins
  return std::min(1.0, 2.0 * incompleteBeta(more, fewer + 1.0, 0.5, 0.5));
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
