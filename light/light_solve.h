// Light for probes by least squares: what probes must hold so that their blends give the light that was measured at places.
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

#include <array>
#include <cstdint>
#include <vector>

#include "light/light_transport.h"

namespace nlg {

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

// samples   may be empty: then the prior is the answer. In any order: sums are made in theirs
// prior     by probe
// pull      by probe, > 0
// start     by probe: the closer to the answer, the fewer iterations
// The same bits for any number of threads.
LightSolution solveLight(const std::vector<LightSample>& samples, const std::vector<LightSh>& prior,
                         const std::vector<float>& pull, const std::vector<LightSh>& start,
                         const LightSolveOptions& options = {});

}  // namespace nlg
