// Loss and gradient of one theta of a network: the part of the shared kernel (loss_kernel.h) for networks.
//
// The formulas are in docs/theory/math.md §4.
// `mlp`: 264 fused multiply-adds a point; the gradient is summed in float over blocks of 256 points, the loss in double over blocks.
#pragma once

#include "nlg/representation.h"
#include "runtime_eval/support/point_set.h"

namespace nlg {

// Sum over points [first, first + count) of (mask (representation(x) - phi))², and its gradient.
//
// first, count   multiples of 16, within points.padded_count
// phi, mask      count floats each; mask 0 leaves a point out (its phi may be anything finite), others weigh it
// theta          D floats
// gradient       D floats, overwritten with d sum / d theta
// returns        the sum; divide both by the number of valid points for the mean
double networkLossAndGradient(const Representation& representation, const PointSet& points, int first, int count,
                              const float* phi, const float* mask, const float* theta, float* gradient);

// The sum alone.
double networkLoss(const Representation& representation, const PointSet& points, int first, int count, const float* phi,
                   const float* mask, const float* theta);

}  // namespace nlg
