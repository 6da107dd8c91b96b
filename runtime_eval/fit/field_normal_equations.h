// Builds the normal equations of one theta of a product field against one weighting function.
//
// A point depends on the 8 nodes of its cell, so that J^T J is a band: nodes are numbered x fastest, and those of one cell lie at
// most 1 + r + r² apart.
#pragma once

#include "runtime_eval/fit/normal_equations.h"

namespace nlg {

// order      cellOrder(r); function is in it
// theta      2 r³ floats
// equations  hessian of 2 r³ rows and bandwidth 2 (1 + r + r²) + 1
void fieldNormalEquations(const PointOrder& order, const WeightingFunction& function, const float* theta,
                          NormalEquations* equations);

}  // namespace nlg
