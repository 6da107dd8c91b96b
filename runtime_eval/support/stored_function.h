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

  bool isValid(size_t point) const { return validity[point / 8] >> (point % 8) & 1; }
  bool isSeen(size_t point) const { return seen[point / 8] >> (point % 8) & 1; }
};

}  // namespace nlg
