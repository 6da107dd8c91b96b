// Looks for the learning rate of a run: a short ramp through all of them, on a state that is thrown away.
//
// After Smith, "Cyclical Learning Rates for Training Neural Networks", 2017.
#pragma once

#include <string>

#include "train/generator/trainer.h"

namespace nlg {

struct RateFinding {
  double steepest = 0.0;   // rate at which the smoothed loss fell fastest
  double diverged = 0.0;   // rate at which it left twice its lowest value, or stopped being finite; the last one if it never did
  double suggested = 0.0;  // the smaller of `steepest` and a tenth of `diverged`
  std::string csv;         // rate,loss,smoothed_loss: one line a step
};

// Takes up to 200 steps from a fresh state, the rate rising exponentially from 1e-6 to 1.
// state   is changed; not to be trained any further
// throws  NumericalError when the loss is not finite at the first step
RateFinding findRate(const TrainOptions& options, const Representation& representation, const TrainingData& training,
                     TrainingState* state);

}  // namespace nlg
