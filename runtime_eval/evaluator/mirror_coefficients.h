// What mirroring a function does to its coefficients: no more than signs, by parity class.
#pragma once

#include <array>

#include "runtime_eval/evaluator/parity_transform.h"

namespace nlg {

// stored_count   coefficients of each class, one class after another, from `coefficients` on
// class_count    how many of each to take, the first ones: at most as many
// mirrored       as many as class_count says
inline void mirrorCoefficients(const std::array<int, kParityClassCount>& stored_count,
                               const std::array<int, kParityClassCount>& class_count, const float* coefficients, int mirror,
                               float* mirrored) {
  for (int c = 0; c < kParityClassCount; ++c) {
    const float sign = mirrorSign(c, mirror);
    for (int k = 0; k < class_count[c]; ++k) *mirrored++ = sign * coefficients[k];
    coefficients += stored_count[c];
  }
}

}  // namespace nlg
