// Evaluates a representation at one point, for look-ups that evaluate 8 thetas at one point each; evaluate.h evaluates one
// theta at many points.
#pragma once

#include "nlg/representation.h"

namespace nlg {

// phi at a point of [-1, 1]³, not clamped. Takes no memory.
// theta   D floats
float evaluatePoint(const Representation& representation, const LocalPoint& point, const float* theta);

// phi over the tent, clamped to [0, 1]; 0 where theta gives no number.
// tent   at the point
float evaluateTentShare(const Representation& representation, const LocalPoint& point, float tent, const float* theta);

}  // namespace nlg
