// The shared kernel: loss and gradient of one theta against one weighting function, for every representation.
//
// Direct optimisation, refinement and the trainer all call these two routines.
#pragma once

#include "nlg/representation.h"

namespace nlg {

// Sum over places [first, first + count) of pointOrder(representation) of (mask (representation(x) - phi))², and its gradient.
//
// first, count   whole minibatches of the order
// phi, mask      count floats each; mask 0 leaves a place out (its phi may be anything finite), others weigh it
// theta          D floats
// gradient       D floats, overwritten with d sum / d theta
// returns        the sum; divide both by the number of valid points for the mean
double lossAndGradient(const Representation& representation, int first, int count, const float* phi, const float* mask,
                       const float* theta, float* gradient);

// The sum alone.
double loss(const Representation& representation, int first, int count, const float* phi, const float* mask, const float* theta);

}  // namespace nlg
