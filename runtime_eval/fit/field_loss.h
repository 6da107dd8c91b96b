// Loss and gradient of one theta of `pf r`: the part of the shared kernel (loss_kernel.h) for product fields.
#pragma once

#include "runtime_eval/support/point_order.h"

namespace nlg {

// Sum over all places of a cell order of (mask (clamp(A, 0, 1) sigmoid(B) - phi))², and its gradient. Where A lies outside [0, 1]
// its derivative is 0; at 0 and 1 themselves it is 1, so that a field whose nodes start there can leave.
//
// order       cellOrder(r)
// phi, mask   order.placeCount() floats each; mask 0 leaves a place out (its phi may be anything finite), others weigh it
// theta       2 r³ floats: nlg/representation.h
// gradient    2 r³ floats, overwritten with d sum / d theta
double fieldLossAndGradient(const PointOrder& order, const float* phi, const float* mask, const float* theta, float* gradient);

// The sum alone.
double fieldLoss(const PointOrder& order, const float* phi, const float* mask, const float* theta);

}  // namespace nlg
