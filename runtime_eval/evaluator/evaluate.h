// Evaluates one theta at many points: what a look-up in the game computes, and what every error is measured on.
#pragma once

#include "runtime_eval/evaluator/representation.h"
#include "runtime_eval/support/support_pattern.h"

namespace nlg {

// values   points.padded_count floats: the representation at each point (not clamped)
// theta    D floats
void evaluate(const Representation& representation, const PointSet& points, const float* theta, float* values);

// The same in double, one point, straight from the formula: what the vector code is tested against.
double evaluateReference(const Representation& representation, const LocalPoint& point, const double* theta);

}  // namespace nlg
