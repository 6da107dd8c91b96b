// The shared kernel: loss and gradient of one theta against one weighting function, for every representation.
//
// Adam and the trainer step by lossAndGradient, and fits of codes compare theta by loss. Levenberg–Marquardt has the same sums in its
// normal equations.
#pragma once

#include "nlg/representation.h"
#include "runtime_eval/evaluator/dictionary.h"
#include "runtime_eval/support/point_order.h"

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

// The part for networks; the formulas are in docs/theory/math.md §4.
// `mlp`: 264 fused multiply-adds a point; the gradient is summed in float over blocks of 256 points, the loss in double over blocks.
//
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

// The part for product fields, `pf r`: sum over all places of a cell order of (mask (clamp(A, 0, 1) sigmoid(B) - phi))², and its
// gradient. Where A lies outside [0, 1] its derivative is 0; at 0 and 1 themselves it is 1, so that a field whose nodes start there
// can leave.
//
// order       cellOrder(r)
// phi, mask   order.placeCount() floats each; mask 0 leaves a place out (its phi may be anything finite), others weigh it
// theta       2 r³ floats: nlg/representation.h
// gradient    2 r³ floats, overwritten with d sum / d theta
double fieldLossAndGradient(const PointOrder& order, const float* phi, const float* mask, const float* theta, float* gradient);

// The sum alone.
double fieldLoss(const PointOrder& order, const float* phi, const float* mask, const float* theta);

// The part for codes. The logits are rounded as a brick has them (dictionary.h); to the gradient that rounding is nothing.
//
// Sum over all places of cellOrder(dictionary.resolution()) of (mask (tent sigmoid(L) - phi))²; gradient by z, K floats, overwritten.
// phi, mask   by place
double codeLossAndGradient(const Dictionary& dictionary, const float* phi, const float* mask, const float* z, float* gradient);

// The sum alone.
double codeLoss(const Dictionary& dictionary, const float* phi, const float* mask, const float* z);

}  // namespace nlg
