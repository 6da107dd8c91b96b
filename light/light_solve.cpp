#include "light/light_solve.h"

#include <algorithm>
#include <cmath>

#include "tool/error.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

using Vector = std::vector<LightSh>;
static_assert(sizeof(LightSh) == kShFloats * sizeof(float), "light is floats, three a coefficient");

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

constexpr uint64_t kBlockProbes = 1024;

// Calls visit(first, end) for every run of samples that read the same probes: those of one cell mostly.
template <class Visit>
void forEachRun(const std::vector<LightSample>& samples, const Visit& visit) {
  const auto reads_the_same = [](const LightSample& a, const LightSample& b) {
    return a.count == b.count && std::equal(a.probe.begin(), a.probe.begin() + a.count, b.probe.begin());
  };
  for (size_t first = 0; first < samples.size();) {
    size_t end = first + 1;
    while (end < samples.size() && reads_the_same(samples[first], samples[end])) ++end;
    visit(first, end);
    first = end;
  }
}

float* floatsOf(LightSh& light) { return &light[0][0]; }
const float* floatsOf(const LightSh& light) { return &light[0][0]; }

}  // namespace

float irradianceSquares(const LightSh& light) {
  float sum = 0.0f;
  for (int k = 0; k < kShCount; ++k) {
    const float band = kCosineBand[k] / kCosineBand[0];
    sum += band * band * glm::dot(light[k], light[k]);
  }
  return sum / kShChannels;
}

LightSolver::LightSolver(const std::vector<LightSample>& samples, size_t probe_count, int thread_count)
    : samples_(samples), thread_count_(thread_count), row_begin_(probe_count + 1, 0) {
  std::vector<std::vector<uint32_t>> beside(probe_count);
  forEachRun(samples_, [&](size_t first, size_t) {
    const LightSample& sample = samples_[first];
    for (int a = 0; a < sample.count; ++a) {
      std::vector<uint32_t>& row = beside[sample.probe[a]];
      for (int b = 0; b < sample.count; ++b) {
        if (std::find(row.begin(), row.end(), sample.probe[b]) == row.end()) row.push_back(sample.probe[b]);
      }
    }
  });
  for (size_t p = 0; p < probe_count; ++p) {
    std::sort(beside[p].begin(), beside[p].end());
    columns_.insert(columns_.end(), beside[p].begin(), beside[p].end());
    row_begin_[p + 1] = columns_.size();
    beside[p] = {};
  }
  values_.resize(columns_.size());
}

float& LightSolver::valueAt(uint32_t row, uint32_t column) {
  const auto begin = columns_.begin() + static_cast<ptrdiff_t>(row_begin_[row]);
  const auto end = columns_.begin() + static_cast<ptrdiff_t>(row_begin_[row + 1]);
  return values_[static_cast<size_t>(std::lower_bound(begin, end, column) - columns_.begin())];
}

void LightSolver::weigh() {
  std::fill(values_.begin(), values_.end(), 0.0f);
  diagonal_.assign(row_begin_.size() - 1, 0.0f);
  forEachRun(samples_, [&](size_t first, size_t end) {
    float sums[8][8] = {};
    const int count = samples_[first].count;
    for (size_t i = first; i < end; ++i) {
      const LightSample& sample = samples_[i];
      for (int a = 0; a < count; ++a) {
        for (int b = 0; b <= a; ++b) sums[a][b] += sample.importance * sample.weight[a] * sample.weight[b];
      }
    }
    const std::array<uint32_t, 8>& probe = samples_[first].probe;
    for (int a = 0; a < count; ++a) {
      diagonal_[probe[a]] += sums[a][a];
      for (int b = 0; b < count; ++b) valueAt(probe[a], probe[b]) += b <= a ? sums[a][b] : sums[b][a];
    }
  });
}

LightSolution LightSolver::solve(const Vector& prior, const std::vector<float>& pull, const Vector& start,
                                 const LightSolveOptions& options) {
  NLG_CHECK(prior.size(), ==, pull.size());
  NLG_CHECK(prior.size(), ==, start.size());
  NLG_CHECK(prior.size() + 1, ==, row_begin_.size());
  weigh();
  std::array<float, kShFloats> order_pull;
  for (size_t i = 0; i < kShFloats; ++i) order_pull[i] = options.order_pull[i < 3 ? 0 : i < 12 ? 1 : 2];

  // of the normal equations
  const auto apply = [&](const Vector& light) {
    Vector image(light.size());
    parallelFor((light.size() + kBlockProbes - 1) / kBlockProbes, thread_count_, [&](uint64_t block, int) {
      const size_t end = std::min<size_t>((block + 1) * kBlockProbes, light.size());
      for (size_t p = block * kBlockProbes; p < end; ++p) {
        float* sum = floatsOf(image[p]);
        const float* own = floatsOf(light[p]);
        for (size_t i = 0; i < kShFloats; ++i) sum[i] = pull[p] * order_pull[i] * own[i];
        for (size_t e = row_begin_[p]; e < row_begin_[p + 1]; ++e) {
          const float* other = floatsOf(light[columns_[e]]);
          for (size_t i = 0; i < kShFloats; ++i) sum[i] += values_[e] * other[i];
        }
      }
    });
    return image;
  };
  const auto preconditioned = [&](const Vector& residual) {
    Vector result = residual;
    for (size_t p = 0; p < result.size(); ++p) {
      float* value = floatsOf(result[p]);
      for (size_t i = 0; i < kShFloats; ++i) value[i] /= diagonal_[p] + pull[p] * order_pull[i];
    }
    return result;
  };
  Vector right(prior.size());
  for (size_t p = 0; p < prior.size(); ++p) {
    for (size_t i = 0; i < kShFloats; ++i) floatsOf(right[p])[i] = pull[p] * order_pull[i] * floatsOf(prior[p])[i];
  }
  for (const LightSample& sample : samples_) {
    for (int j = 0; j < sample.count; ++j) {
      const float weight = sample.importance * sample.weight[j];
      for (int k = 0; k < kShCount; ++k) right[sample.probe[j]][k] += weight * sample.light[k];
    }
  }
  const auto residualAt = [&](const Vector& light) {
    Vector residual = apply(light);
    for (size_t p = 0; p < residual.size(); ++p) {
      for (int k = 0; k < kShCount; ++k) residual[p][k] = right[p][k] - residual[p][k];
    }
    return residual;
  };

  LightSolution solution{start, 0, 0.0};
  const Vector at_prior = residualAt(prior);
  const double first = total(dot(at_prior, preconditioned(at_prior)));
  Vector residual = residualAt(start);
  Vector direction = preconditioned(residual);
  Sums energy = dot(residual, direction);
  while (solution.iterations < options.max_iterations && total(energy) > options.tolerance * options.tolerance * first) {
    const Vector image = apply(direction);
    const Sums curvature = dot(direction, image);
    LightSh step, share;
    for (int k = 0; k < kShCount; ++k) step[k] = quotient(energy.value[k], curvature.value[k]);
    for (size_t p = 0; p < direction.size(); ++p) {
      for (int k = 0; k < kShCount; ++k) {
        solution.light[p][k] += step[k] * direction[p][k];
        residual[p][k] -= step[k] * image[p][k];
      }
    }
    const Vector next = preconditioned(residual);
    const Sums next_energy = dot(residual, next);
    for (int k = 0; k < kShCount; ++k) share[k] = quotient(next_energy.value[k], energy.value[k]);
    for (size_t p = 0; p < direction.size(); ++p) {
      for (int k = 0; k < kShCount; ++k) direction[p][k] = next[p][k] + share[k] * direction[p][k];
    }
    energy = next_energy;
    ++solution.iterations;
  }
  solution.residual = first > 0.0 ? std::sqrt(total(energy) / first) : 0.0;
  return solution;
}

LightSh blendOf(const LightSample& sample, const std::vector<LightSh>& light) {
  LightSh sum{};
  for (int j = 0; j < sample.count; ++j) {
    for (int k = 0; k < kShCount; ++k) sum[k] += sample.weight[j] * light[sample.probe[j]][k];
  }
  return sum;
}

LightSolution solveLight(const std::vector<LightSample>& samples, const std::vector<LightSh>& prior,
                         const std::vector<float>& pull, const std::vector<LightSh>& start, const LightSolveOptions& options) {
  return LightSolver(samples, prior.size(), 1).solve(prior, pull, start, options);
}

}  // namespace nlg
