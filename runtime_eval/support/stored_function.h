// A weighting function as data sets store it: the one view that whoever reads or compares stored functions takes.
//
// Without any other header, so that a data set can hand out the view without linking what evaluates functions.
#pragma once

#include <cstddef>
#include <cstdint>

namespace nlg {

// P is the number of its support points, which the owner of the samples knows; all pointers must outlive the view.
struct StoredFunction {
  const uint8_t* phi = nullptr;       // P, round(255 phi), pattern order; 0 where a point is not valid
  const uint8_t* validity = nullptr;  // P / 8, bit i of byte b is point 8 b + i
  const uint8_t* seen = nullptr;      // likewise, the points that the probe sees; null where nobody asks for them
  // P, round(255 min(1, S)), S being the sum of all functions of the cell's probes at the point: what the loss weighs lit points by
  // (loss_weights.h). Null: S is taken as 1 everywhere, as if other probes saw whatever this one sees.
  const uint8_t* blend_sum = nullptr;

  bool isValid(size_t point) const { return validity[point / 8] >> (point % 8) & 1; }
  bool isSeen(size_t point) const { return seen[point / 8] >> (point % 8) & 1; }
  uint8_t blendSum(size_t point) const { return blend_sum == nullptr ? 255 : blend_sum[point]; }
};

}  // namespace nlg
