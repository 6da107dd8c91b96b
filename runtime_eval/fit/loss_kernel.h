// The shared kernel: loss of one theta against one weighting function, and its gradient, for every representation.
//
// Direct optimisation, refinement and the trainer all call these two routines.
#pragma once

#include "runtime_eval/evaluator/representation.h"

namespace nlg {

// Sum over the points of one batch of pointOrder(representation) of mask * (representation(x) - phi)², and its gradient.
//
// batch       < pointOrder(representation).batchCount()
// phi, mask   as many floats as the batch has places; mask 0 leaves a place out (its phi may be anything finite)
// theta       D floats
// gradient    D floats, overwritten with d sum / d theta
// returns     the sum; divide both by the number of valid points for the mean
double lossAndGradient(const Representation& representation, int batch, const float* phi, const float* mask, const float* theta,
                       float* gradient);

// The sum alone.
double loss(const Representation& representation, int batch, const float* phi, const float* mask, const float* theta);

}  // namespace nlg
