// Solves for probe light by least squares, so that blends give the light measured at sample points.
//
// The talk states the whole reconstruction as one minimisation and then gives every probe the integral of light under its own
// function instead; here the linear half of that minimisation is solved, with the functions as they are. Minimised is
//
//   sum over samples   importance * | sum over probes of weight * L(probe) - light |²
// + sum over probes    pull * | L(probe) - prior(probe) |²      (pull times its order's, for coefficients of each order)
//
// for each coefficient and channel by itself. The prior holds probes that few samples read, and keeps all of them from taking
// values that only the sums need. Conjugate gradients with a diagonal preconditioner; all 27 right-hand sides at once.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "light/light_transport.h"
#include "tool/parallel_for.h"

namespace nlg {

// The mean square of irradiance over all normals and channels, in the unit of a first coefficient: of a difference, how far it is seen.
float irradianceSquares(const LightSh& light);

// What a blend at one place should give.
struct LightSample {
  std::array<uint32_t, 8> probe{};
  std::array<float, 8> weight{};  // of the first `count`: >= 0, they sum to 1
  int count = 0;                  // 1 … 8
  float importance = 1.0f;        // > 0
  LightSh light{};
};

// What it is with this light.
// light   by probe
LightSh blendOf(const LightSample& sample, const std::vector<LightSh>& light);

struct LightSolveOptions {
  int max_iterations = 100;
  double tolerance = 1e-4;                               // of the residual against the first one: ends the iterations
  std::array<float, 3> order_pull = {1.0f, 1.0f, 1.0f};  // > 0: how much harder the prior pulls at coefficients of order 0, 1, 2
};

struct LightSolution {
  std::vector<LightSh> light;  // by probe
  int iterations = 0;
  double residual = 0.0;  // as tolerance has it
};

// The solve of one set of samples, again and again: which probes they read together is found once. What probes weigh together at places
// is a sparse matrix, a row of some 27 a probe, where the samples themselves are a dozen a cell with eight probes each.
class LightSolver {
 public:
  // samples   must outlive it; their probes, weights and order stay as they are. May be empty: then the prior is the answer
  LightSolver(const std::vector<LightSample>& samples, size_t probe_count, int thread_count);

  // With the importance and light that samples have now. The same bits for any number of threads.
  // prior   by probe
  // pull    by probe, > 0
  // start   by probe: the closer to the answer, the fewer iterations
  LightSolution solve(const std::vector<LightSh>& prior, const std::vector<float>& pull, const std::vector<LightSh>& start,
                      const LightSolveOptions& options = {});

  // Calls visit(p) for every probe, in blocks of neighbours on several threads.
  template <class Visit>
  void forEachProbe(const Visit& visit) const {
    parallelForBlocks(read_begin_.size() - 1, kBlockProbes, thread_count_, [&](uint64_t first, uint64_t end, int) {
      for (size_t p = first; p < end; ++p) visit(p);
    });
  }
  // Calls visit(i, weight) for every sample i that reads a probe, in their order.
  template <class Visit>
  void forEachRead(size_t probe, const Visit& visit) const {
    for (size_t r = read_begin_[probe]; r < read_begin_[probe + 1]; ++r) {
      const LightSample& sample = samples_[reads_[r]];
      const auto at = std::find(sample.probe.begin(), sample.probe.end(), static_cast<uint32_t>(probe));
      visit(reads_[r], sample.weight[static_cast<size_t>(at - sample.probe.begin())]);
    }
  }

 private:
  static constexpr uint64_t kBlockProbes = 1024;

  // Samples that read the same probes one after the other, those of one cell mostly.
  struct Run {
    size_t first, end;
    size_t first_pair;  // into pairs_: every of these probes with every of them
  };
  size_t indexOf(uint32_t row, uint32_t column) const;
  void weigh();

  const std::vector<LightSample>& samples_;
  const int thread_count_;
  std::vector<size_t> row_begin_;  // by probe, into columns_ and values_; one more at the end
  std::vector<uint32_t> columns_;  // probes, rising within a row
  std::vector<float> values_;      // sum over samples of importance * weight * weight
  std::vector<Run> runs_;
  std::vector<size_t> pairs_;       // into values_
  std::vector<size_t> read_begin_;  // by probe, into reads_; one more at the end
  std::vector<uint32_t> reads_;     // samples that read it, rising
};

// The same once, on the calling thread.
LightSolution solveLight(const std::vector<LightSample>& samples, const std::vector<LightSh>& prior,
                         const std::vector<float>& pull, const std::vector<LightSh>& start,
                         const LightSolveOptions& options = {});

}  // namespace nlg
