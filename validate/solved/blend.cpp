#include "validate/solved/blend.h"

#include <algorithm>
#include <cmath>

#include "tool/error.h"

namespace nlg {
namespace {

constexpr float kNoWeight = 1e-6f;
constexpr double kRidge = 1e-7;

// Overwrites the lower triangle of a positive definite n x n matrix with its Cholesky factor.
void factor(std::vector<double>& matrix, size_t n) {
  for (size_t c = 0; c < n; ++c) {
    for (size_t r = c; r < n; ++r) {
      double sum = matrix[r * n + c];
      for (size_t k = 0; k < c; ++k) sum -= matrix[r * n + k] * matrix[c * n + k];
      if (r > c) {
        matrix[r * n + c] = sum / matrix[c * n + c];
        continue;
      }
      if (!(sum > 0.0)) throw NumericalError("solve", "probe " + std::to_string(c), "pivot", sum);
      matrix[c * n + c] = std::sqrt(sum);
    }
  }
}

// Solves for `width` right-hand sides at once, in place: rows of `right` are the unknowns.
void substitute(const std::vector<double>& lower, size_t n, size_t width, std::vector<double>& right) {
  const auto subtract = [&](size_t row, size_t from, double factor_of) {
    for (size_t s = 0; s < width; ++s) right[row * width + s] -= factor_of * right[from * width + s];
  };
  const auto divide = [&](size_t row) {
    for (size_t s = 0; s < width; ++s) right[row * width + s] /= lower[row * n + row];
  };
  for (size_t r = 0; r < n; ++r) {
    for (size_t k = 0; k < r; ++k) subtract(r, k, lower[r * n + k]);
    divide(r);
  }
  for (size_t r = n; r-- > 0;) {
    for (size_t k = r + 1; k < n; ++k) subtract(r, k, lower[k * n + r]);
    divide(r);
  }
}

}  // namespace

BlendWeights normalised(const BlendWeights& weights) {
  BlendWeights result(weights.size());
  for (size_t i = 0; i < weights.size(); ++i) {
    float sum = 0.0f;
    for (const float w : weights[i]) sum += w;
    if (sum < kNoWeight) continue;
    for (int c = 0; c < kCornerCount; ++c) result[i][c] = weights[i][c] / sum;
  }
  return result;
}

std::vector<float> pointsOf(const SamplePoints& points, std::initializer_list<PointUse> uses) {
  std::vector<float> counts(points.count());
  for (size_t i = 0; i < counts.size(); ++i) counts[i] = std::find(uses.begin(), uses.end(), points.use[i]) != uses.end();
  return counts;
}

std::vector<float> solveProbes(const SamplePoints& points, const BlendWeights& weights, const Signals& signals,
                               const std::vector<float>& counts) {
  const size_t n = points.probe_position_m.size(), width = signals.count;
  std::vector<double> matrix(n * n, 0.0), right(n * width, 0.0);
  for (size_t i = 0; i < points.count(); ++i) {
    if (counts[i] == 0.0f) continue;
    for (int c = 0; c < kCornerCount; ++c) {
      const double w = double{counts[i]} * weights[i][c];
      if (w == 0.0) continue;
      const size_t row = points.probe[i][c];
      for (int d = 0; d < kCornerCount; ++d) {
        if (weights[i][d] != 0.0f) matrix[row * n + points.probe[i][d]] += w * weights[i][d];
      }
      const float* signal = signals.row(i);
      for (size_t s = 0; s < width; ++s) right[row * width + s] += w * signal[s];
    }
  }
  double trace = 0.0;
  for (size_t p = 0; p < n; ++p) trace += matrix[p * n + p];
  for (size_t p = 0; p < n; ++p) matrix[p * n + p] += kRidge * std::max(trace, 1e-30) / static_cast<double>(n);
  factor(matrix, n);
  substitute(matrix, n, width, right);
  return {right.begin(), right.end()};
}

void blend(const std::array<int, kCornerCount>& probe, const std::array<float, kCornerCount>& weights,
           const std::vector<float>& probes, int signal_count, float* out) {
  std::fill(out, out + signal_count, 0.0f);
  for (int c = 0; c < kCornerCount; ++c) {
    const float w = weights[c];
    if (w == 0.0f) continue;
    const float* row = &probes[size_t(probe[c]) * signal_count];
    for (int s = 0; s < signal_count; ++s) out[s] += w * row[s];
  }
}

std::vector<double> squaredErrors(const SamplePoints& points, const BlendWeights& weights, const std::vector<float>& probes,
                                  const Signals& signals) {
  std::vector<double> errors(points.count());
  std::vector<float> blended(signals.count);
  for (size_t i = 0; i < points.count(); ++i) {
    blend(points.probe[i], weights[i], probes, signals.count, blended.data());
    double sum = 0.0;
    for (int s = 0; s < signals.count; ++s) {
      const double residual = blended[s] - signals.row(i)[s];
      sum += residual * residual;
    }
    errors[i] = sum / signals.count;
  }
  return errors;
}

}  // namespace nlg
