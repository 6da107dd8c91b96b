#include "light/light_solve.h"

#include <algorithm>
#include <cmath>

#include "tool/error.h"

namespace nlg {
namespace {

using Vector = std::vector<LightSh>;

// Sums by coefficient and channel.
struct Sums {
  std::array<glm::dvec3, kShCount> value{};
};

Sums dot(const Vector& a, const Vector& b) {
  Sums sums;
  for (size_t i = 0; i < a.size(); ++i) {
    for (int k = 0; k < kShCount; ++k) sums.value[k] += glm::dvec3(a[i][k] * b[i][k]);
  }
  return sums;
}

double total(const Sums& sums) {
  double sum = 0.0;
  for (const glm::dvec3& value : sums.value) sum += value.r + value.g + value.b;
  return sum;
}

// Where the divisor is 0 there is nothing left to do: that right-hand side stands still.
glm::vec3 quotient(const glm::dvec3& a, const glm::dvec3& b) {
  glm::vec3 result(0.0f);
  for (int c = 0; c < kShChannels; ++c) result[c] = b[c] > 0.0 ? static_cast<float>(a[c] / b[c]) : 0.0f;
  return result;
}

class Solver {
 public:
  Solver(const std::vector<LightSample>& samples, const Vector& prior, const std::vector<float>& pull,
         const std::array<float, 3>& order_pull)
      : samples_(samples), prior_(prior), pull_(pull), curvature_(pull.size(), 0.0f) {
    for (int k = 0; k < kShCount; ++k) order_pull_[k] = order_pull[k == 0 ? 0 : k < 4 ? 1 : 2];
    for (const LightSample& sample : samples_) {
      for (int j = 0; j < sample.count; ++j)
        curvature_[sample.probe[j]] += sample.importance * sample.weight[j] * sample.weight[j];
    }
  }

  LightSolution solve(const Vector& start, const LightSolveOptions& options) {
    LightSolution solution{start, 0, 0.0};
    const Vector at_prior = residualAt(prior_);
    const double first = total(dot(at_prior, preconditioned(at_prior)));
    Vector residual = residualAt(start);
    Vector direction = preconditioned(residual);
    Sums energy = dot(residual, direction);
    while (solution.iterations < options.max_iterations && total(energy) > options.tolerance * options.tolerance * first) {
      const Vector image = apply(direction);
      const Sums curvature = dot(direction, image);
      for (int k = 0; k < kShCount; ++k) {
        const glm::vec3 step = quotient(energy.value[k], curvature.value[k]);
        for (size_t p = 0; p < direction.size(); ++p) {
          solution.light[p][k] += step * direction[p][k];
          residual[p][k] -= step * image[p][k];
        }
      }
      const Vector next = preconditioned(residual);
      const Sums next_energy = dot(residual, next);
      for (int k = 0; k < kShCount; ++k) {
        const glm::vec3 share = quotient(next_energy.value[k], energy.value[k]);
        for (size_t p = 0; p < direction.size(); ++p) direction[p][k] = next[p][k] + share * direction[p][k];
      }
      energy = next_energy;
      ++solution.iterations;
    }
    solution.residual = first > 0.0 ? std::sqrt(total(energy) / first) : 0.0;
    return solution;
  }

 private:
  // Of the normal equations.
  Vector residualAt(const Vector& light) const {
    Vector residual(light.size());
    for (size_t p = 0; p < light.size(); ++p) {
      for (int k = 0; k < kShCount; ++k) residual[p][k] = pull_[p] * order_pull_[k] * (prior_[p][k] - light[p][k]);
    }
    for (const LightSample& sample : samples_) {
      const LightSh blended = blendOf(sample, light);
      for (int j = 0; j < sample.count; ++j) {
        const float weight = sample.importance * sample.weight[j];
        for (int k = 0; k < kShCount; ++k) residual[sample.probe[j]][k] += weight * (sample.light[k] - blended[k]);
      }
    }
    return residual;
  }

  Vector apply(const Vector& light) const {
    Vector image(light.size());
    for (size_t p = 0; p < light.size(); ++p) {
      for (int k = 0; k < kShCount; ++k) image[p][k] = pull_[p] * order_pull_[k] * light[p][k];
    }
    for (const LightSample& sample : samples_) {
      const LightSh blended = blendOf(sample, light);
      for (int j = 0; j < sample.count; ++j) {
        const float weight = sample.importance * sample.weight[j];
        for (int k = 0; k < kShCount; ++k) image[sample.probe[j]][k] += weight * blended[k];
      }
    }
    return image;
  }

  Vector preconditioned(const Vector& residual) const {
    Vector result = residual;
    for (size_t p = 0; p < result.size(); ++p) {
      for (int k = 0; k < kShCount; ++k) result[p][k] /= curvature_[p] + pull_[p] * order_pull_[k];
    }
    return result;
  }

  const std::vector<LightSample>& samples_;
  const Vector& prior_;
  const std::vector<float>& pull_;
  std::array<float, kShCount> order_pull_{};  // by coefficient
  std::vector<float> curvature_;              // of the samples, by probe
};

}  // namespace

LightSh blendOf(const LightSample& sample, const std::vector<LightSh>& light) {
  LightSh sum{};
  for (int j = 0; j < sample.count; ++j) {
    for (int k = 0; k < kShCount; ++k) sum[k] += sample.weight[j] * light[sample.probe[j]][k];
  }
  return sum;
}

LightSolution solveLight(const std::vector<LightSample>& samples, const std::vector<LightSh>& prior,
                         const std::vector<float>& pull, const std::vector<LightSh>& start, const LightSolveOptions& options) {
  NLG_CHECK(prior.size(), ==, pull.size());
  NLG_CHECK(prior.size(), ==, start.size());
  return Solver(samples, prior, pull, options.order_pull).solve(start, options);
}

}  // namespace nlg
