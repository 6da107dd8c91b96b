// Evaluates one theta at many points.
#pragma once

#include "runtime_eval/evaluator/kernel_shape.h"

namespace nlg {

// values   points.padded_count floats: the representation at each point, as its formula says (a linear output is not clamped)
// theta    D floats
void evaluate(const Representation& representation, const PointSet& points, const float* theta, float* values);

// The same in double, one point, straight from the formula: what the vector code is tested against.
double evaluateReference(const Representation& representation, const LocalPoint& point, const double* theta);

// Of any network, whether or not it is one of kNetworks.
double evaluateNetworkReference(const NetworkKind& network, double slope, const LocalPoint& point, const double* theta);

}  // namespace nlg
