// Solves a network's last layer exactly: given the hidden values its 9 numbers (of `mlp`) are linear, so that the best follow
// from 9 x 9 normal equations (variable projection, Golub & Pereyra 1973). docs/theory/math.md §5.
#pragma once

#include "nlg/representation.h"
#include "runtime_eval/fit/symmetric_band.h"
#include "runtime_eval/support/weighting_function.h"

namespace nlg {

// Of each diagonal entry of the equations, added to it: numbers that hardly matter stay small, which float16 and bytes hold better.
// It costs no error that is seen (docs/lab/training.md).
inline constexpr double kLastLayerRidge = 1e-6;

// Replaces w3 and b3 of a network's theta by those of least squares over the valid points. Hidden units that are nearly a
// combination of others get as little weight as the ridge gives them, and another of 1e-9 of the largest diagonal entry.
// theta     D floats
// returns   false, and theta unchanged, when the network's output is not linear, the equations cannot be solved or their solution
//           is not finite
bool solveLastLayer(const Representation& representation, const WeightingFunction& function, float* theta);

// The same over places [first, first + count) of the order alone; phi and mask are theirs, as for the loss (loss_kernel.h).
bool solveLastLayer(const Representation& representation, int first, int count, const float* phi, const float* mask,
                    float* theta);

// The same, allocating nothing after the first call with these equations: memory that the call overwrites.
bool solveLastLayer(const Representation& representation, int first, int count, const float* phi, const float* mask, float* theta,
                    SymmetricBand* equations, double ridge = kLastLayerRidge);

}  // namespace nlg
