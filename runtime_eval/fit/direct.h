// Direct optimisation: fits theta to one function to convergence, the reference for every generator.
#pragma once

#include <cstdint>

#include "runtime_eval/fit/adam.h"
#include "runtime_eval/fit/levenberg_marquardt.h"

namespace nlg {

struct DirectOptions {
  int adam_steps = 32000;         // from theta0, and from every random start; product fields and codes: a 32nd of it
  int levenberg_iterations = 40;  // from theta0, and after every Adam
  int restarts = 2;               // random starts
  uint64_t seed = 1;
};

// Adam's steps of every start: a field's step reads all points, so that it takes fewer of them for the same work.
int directAdamSteps(const Representation& representation, const DirectOptions& options);

// Best of: Adam from theta0, then LM; LM from theta0; Adam from each random start, then LM; for product fields also fitNested, for codes LM
// from each random start. LM is longLevenbergMarquardt.
FitResult fitDirect(const Representation& representation, const WeightingFunction& function, const Theta& theta0,
                    const DirectOptions& options, NormalEquationsKernel* kernel);

// A product field from coarse to fine: LM on 3³ nodes from the tent, then on grids that hold the nodes of the one before (3, 5, 9
// or 3, 7), each from the field that stands. Ends far lower than a fit of all nodes at once.
// function     in the order of `representation`, a field
// iterations   of LM on every grid
FitResult fitNested(const Representation& representation, const WeightingFunction& function, int iterations,
                    NormalEquationsKernel* kernel);

struct StartOptions {
  int candidates = 1500;  // random starts; most of them end in poor minima, so many are tried shortly
  int candidate_steps = 2400;
  int finalists = 16;  // of these the best are fitted on
  int final_steps = 24000;
  int levenberg_iterations = 100;
  uint64_t seed = 1;
};

// theta0: a network fitted to one function from nothing, as well as many random starts allow, or a field from coarse to fine. The
// start of every other fit, and the constant part of the generator's output.
FitResult fitStart(const Representation& representation, const WeightingFunction& function, const StartOptions& options,
                   NormalEquationsKernel* kernel);

}  // namespace nlg
