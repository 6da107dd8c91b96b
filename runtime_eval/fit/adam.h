// Fits theta by Adam (Kingma & Ba 2015), with one minibatch of points per step (networks: 256; product fields: all points).
// Networks step in the eigenbasis of their layers' gradients (adam_update.h).
#pragma once

#include <cstdint>

#include <vector>

#include "runtime_eval/fit/adam_update.h"
#include "runtime_eval/fit/fit_result.h"

namespace nlg {

struct AdamOptions {
  int steps = 8000;
  double learning_rate = 0.005;  // at the start; falls to 0 along a cosine
  double beta1 = 0.8;
  double beta2 = 0.99;      // short memory: fits last a few hundred to a few thousand steps
  bool full_batch = false;  // every step reads all points
  bool eigenbasis = true;   // networks; false: plain Adam
  uint64_t seed = 1;        // order of the batches
};

// Learning rates that measured best for a start near the solution (docs/lab/training.md).
AdamOptions refinementAdam(const Representation& representation, int steps);
// … and for a random start.
AdamOptions randomStartAdam(const Representation& representation, int steps);

// What steps keep between each other; from one function to the next of the same representation it allocates nothing.
class AdamWorkspace {
 private:
  friend class AdamRun;
  // Places from `first` on, and how many of them are valid.
  struct Minibatch {
    int first = 0, valid_count = 0;
  };
  std::vector<Minibatch> order_;
  Theta moving_, gradient_;
  AdamMoments moments_;
  SoapMoments soap_moments_;
};

// Steps in place.
// theta      D floats; becomes the better of the last theta and what it was
// returns    rmse, steps and stop of the fit, without its theta
FitResult iterateAdam(const Representation& representation, const WeightingFunction& function, const AdamOptions& options,
                      AdamWorkspace* workspace, float* theta);

// Fits theta to the function from `start`. Returns the better of the last theta and the start; steps that turn not finite end it.
FitResult fitAdam(const Representation& representation, const WeightingFunction& function, const Theta& start,
                  const AdamOptions& options);

// A random start. Networks: He-normal layers, biases spread over the support. Product fields: A in [.2, .8], B around 0.
// Codes: as their dictionary's deviations say.
Theta randomTheta(const Representation& representation, uint64_t seed);

}  // namespace nlg
