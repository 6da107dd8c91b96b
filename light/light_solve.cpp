// The normal equations are sparse and kept: their pattern is found once,
// and every round fills it anew from runs of samples in one cell.
#include "light/light_solve.h"

#include <cmath>
#include <functional>
#include <numeric>

#include "tool/error.h"

namespace nlg {
namespace {

using Vector = std::vector<LightSh>;
static_assert(sizeof(LightSh) == kShFloats * sizeof(float), "light is floats, three a coefficient");

// Sums by coefficient and channel.
using Sums = std::array<double, kShFloats>;

double total(const Sums& sums) { return std::accumulate(sums.begin(), sums.end(), 0.0); }

// Where the divisor is 0 there is nothing left to do: that right-hand side stands still.
std::array<float, kShFloats> quotients(const Sums& a, const Sums& b) {
  std::array<float, kShFloats> result;
  for (size_t i = 0; i < kShFloats; ++i) result[i] = b[i] > 0.0 ? static_cast<float>(a[i] / b[i]) : 0.0f;
  return result;
}

size_t orderOf(size_t coefficient) { return coefficient < 3 ? 0 : coefficient < 12 ? 1 : 2; }

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
    : samples_(samples), thread_count_(thread_count), row_begin_(probe_count + 1, 0), read_begin_(probe_count + 1, 0) {
  // the pattern of the normal equations: a probe's row has a column for each probe that some sample reads beside it
  std::vector<std::vector<uint32_t>> beside(probe_count);
  size_t pair_count = 0;
  forEachRun(samples_, [&](size_t first, size_t end) {
    const LightSample& sample = samples_[first];
    runs_.push_back({first, end, pair_count});
    pair_count += static_cast<size_t>(sample.count * sample.count);
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
  // where the pairs of a run add up is found once, since every round weighs anew
  values_.resize(columns_.size());
  for (const Run& run : runs_) {
    const LightSample& sample = samples_[run.first];
    for (int a = 0; a < sample.count; ++a) {
      for (int b = 0; b < sample.count; ++b) pairs_.push_back(indexOf(sample.probe[a], sample.probe[b]));
    }
  }
  // by probe, the samples that read it: for the right-hand sides
  for (const LightSample& sample : samples_) {
    for (int j = 0; j < sample.count; ++j) ++read_begin_[sample.probe[j] + 1];
  }
  std::partial_sum(read_begin_.begin(), read_begin_.end(), read_begin_.begin());
  reads_.resize(read_begin_.back());
  std::vector<size_t> next = read_begin_;
  for (uint32_t i = 0; i < samples_.size(); ++i) {
    for (int j = 0; j < samples_[i].count; ++j) reads_[next[samples_[i].probe[j]]++] = i;
  }
}

// Into columns_ and values_: the row has such a column.
size_t LightSolver::indexOf(uint32_t row, uint32_t column) const {
  const auto begin = columns_.begin() + static_cast<ptrdiff_t>(row_begin_[row]);
  const auto end = columns_.begin() + static_cast<ptrdiff_t>(row_begin_[row + 1]);
  return static_cast<size_t>(std::lower_bound(begin, end, column) - columns_.begin());
}

void LightSolver::weigh() {
  std::vector<float> sums(pairs_.size(), 0.0f);
  constexpr uint64_t kBlockRuns = 256;
  parallelForBlocks(runs_.size(), kBlockRuns, thread_count_, [&](uint64_t first, uint64_t end, int) {
    for (size_t r = first; r < end; ++r) {
      const Run& run = runs_[r];
      for (size_t i = run.first; i < run.end; ++i) {
        const LightSample& sample = samples_[i];
        float* sum = &sums[run.first_pair];
        for (int a = 0; a < sample.count; ++a) {
          for (int b = 0; b < sample.count; ++b) *sum++ += sample.importance * (sample.weight[a] * sample.weight[b]);
        }
      }
    }
  });
  // in the order of runs, so that sums do not depend on threads
  std::fill(values_.begin(), values_.end(), 0.0f);
  for (size_t i = 0; i < pairs_.size(); ++i) values_[pairs_[i]] += sums[i];
}

LightSolution LightSolver::solve(const Vector& prior, const std::vector<float>& pull, const Vector& start,
                                 const LightSolveOptions& options) {
  NLG_CHECK(prior.size(), ==, pull.size());
  NLG_CHECK(prior.size(), ==, start.size());
  NLG_CHECK(prior.size() + 1, ==, row_begin_.size());
  weigh();
  std::vector<float> diagonal(prior.size(), 0.0f);
  for (uint32_t p = 0; p < prior.size(); ++p) {
    // a row without pairs is of a probe that no sample point reads
    if (row_begin_[p] < row_begin_[p + 1]) diagonal[p] = values_[indexOf(p, p)];
  }
  // by passes over blocks of probes, whose sums are added up in their order
  const auto overBlocks = [&](const auto& work) {
    std::vector<Sums> sums((prior.size() + kBlockProbes - 1) / kBlockProbes, Sums{});
    forEachProbe([&](size_t p) { work(p, &sums[p / kBlockProbes]); });
    Sums all{};
    for (const Sums& sum : sums) std::transform(sum.begin(), sum.end(), all.begin(), all.begin(), std::plus<>());
    return all;
  };
  // of the normal equations
  const auto rowTimes = [&](size_t p, const Vector& light, float* sum) {
    const float* own = floatsOf(light[p]);
    for (size_t i = 0; i < kShFloats; ++i) sum[i] = pull[p] * options.order_pull[orderOf(i)] * own[i];
    for (size_t e = row_begin_[p]; e < row_begin_[p + 1]; ++e) {
      const float* other = floatsOf(light[columns_[e]]);
      for (size_t i = 0; i < kShFloats; ++i) sum[i] += values_[e] * other[i];
    }
  };
  const auto preconditioned = [&](size_t p, const float* residual, float* result) {
    std::array<float, 3> inverse;
    for (size_t order = 0; order < 3; ++order) inverse[order] = 1.0f / (diagonal[p] + pull[p] * options.order_pull[order]);
    for (size_t i = 0; i < kShFloats; ++i) result[i] = residual[i] * inverse[orderOf(i)];
  };
  // the right-hand side: the pull to the prior, and the samples' light under shares and importance
  Vector right(prior.size()), residual(prior.size()), direction(prior.size()), image(prior.size());
  forEachProbe([&](size_t p) {
    float* sum = floatsOf(right[p]);
    for (size_t i = 0; i < kShFloats; ++i) sum[i] = pull[p] * options.order_pull[orderOf(i)] * floatsOf(prior[p])[i];
    forEachRead(p, [&](size_t s, float weight) {
      for (size_t i = 0; i < kShFloats; ++i) sum[i] += samples_[s].importance * weight * floatsOf(samples_[s].light)[i];
    });
  });
  // what is left at a light, and where to go from there; returns the square of its length
  const auto begin = [&](const Vector& light) {
    return overBlocks([&](size_t p, Sums* energy) {
      float *left = floatsOf(residual[p]), *way = floatsOf(direction[p]);
      rowTimes(p, light, left);
      for (size_t i = 0; i < kShFloats; ++i) left[i] = floatsOf(right[p])[i] - left[i];
      preconditioned(p, left, way);
      for (size_t i = 0; i < kShFloats; ++i) (*energy)[i] += left[i] * way[i];
    });
  };

  // conjugate gradients with a diagonal preconditioner: 27 systems in one pass, each with steps of its own
  LightSolution solution{start, 0, 0.0};
  // the tolerance is relative to what is left at the prior
  const double first = total(begin(prior));
  Sums energy = begin(start);
  while (solution.iterations < options.max_iterations && total(energy) > options.tolerance * options.tolerance * first) {
    const Sums curvature = overBlocks([&](size_t p, Sums* sum) {
      const float *way = floatsOf(direction[p]), *row = floatsOf(image[p]);
      rowTimes(p, direction, floatsOf(image[p]));
      for (size_t i = 0; i < kShFloats; ++i) (*sum)[i] += way[i] * row[i];
    });
    const std::array<float, kShFloats> step = quotients(energy, curvature);
    const Sums next_energy = overBlocks([&](size_t p, Sums* sum) {
      float *light = floatsOf(solution.light[p]), *left = floatsOf(residual[p]);
      const float *way = floatsOf(direction[p]), *row = floatsOf(image[p]);
      for (size_t i = 0; i < kShFloats; ++i) {
        light[i] += step[i] * way[i];
        left[i] -= step[i] * row[i];
      }
      std::array<float, kShFloats> next;
      preconditioned(p, left, next.data());
      for (size_t i = 0; i < kShFloats; ++i) (*sum)[i] += left[i] * next[i];
    });
    const std::array<float, kShFloats> share = quotients(next_energy, energy);
    forEachProbe([&](size_t p) {
      std::array<float, kShFloats> next;
      preconditioned(p, floatsOf(residual[p]), next.data());
      float* way = floatsOf(direction[p]);
      for (size_t i = 0; i < kShFloats; ++i) way[i] = next[i] + share[i] * way[i];
    });
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
