// Evaluates one theta at many points, or at one: look-ups evaluate 8 thetas at one point each.
#pragma once

#include "nlg/representation.h"
#include "runtime_eval/evaluator/kernel_shape.h"

namespace nlg {

// values   points.padded_count floats: the representation at each point, as its formula says (a linear output is not clamped)
// theta    D floats
void evaluate(const Representation& representation, const PointSet& points, const float* theta, float* values);

// The same in double, one point, straight from the formula: what the vector code is tested against.
double evaluateReference(const Representation& representation, const LocalPoint& point, const double* theta);

// Of any network, whether or not it is one of kNetworks.
double evaluateNetworkReference(const NetworkKind& network, double slope, const LocalPoint& point, const double* theta);

// phi at a point of [-1, 1]³, not clamped. Takes no memory.
// theta   D floats
float evaluatePoint(const Representation& representation, const LocalPoint& point, const float* theta);

// phi over the tent, clamped to [0, 1]; 0 where theta gives no number.
// tent   at the point
float evaluateTentShare(const Representation& representation, const LocalPoint& point, float tent, const float* theta);

}  // namespace nlg
