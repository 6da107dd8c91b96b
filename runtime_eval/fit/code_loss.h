// Loss and gradient of one code against one weighting function: the part of the shared kernel (loss_kernel.h) for codes.
//
// The logits are rounded as a brick has them (dictionary.h); to the gradient that rounding is nothing.
#pragma once

#include "runtime_eval/evaluator/dictionary.h"

namespace nlg {

// Sum over all places of cellOrder(dictionary.resolution()) of (mask (tent sigmoid(L) - phi))²; gradient by z, K floats, overwritten.
// phi, mask   by place
double codeLossAndGradient(const Dictionary& dictionary, const float* phi, const float* mask, const float* z, float* gradient);

// The sum alone.
double codeLoss(const Dictionary& dictionary, const float* phi, const float* mask, const float* z);

}  // namespace nlg
