// Slices through weighting functions, for pictures.
#pragma once

#include <vector>

#include "datagen/dataset/function_set.h"
#include "runtime_eval/evaluator/representation.h"

namespace nlg {

// A square picture of one plane through the probe: rows x columns = size x size, local coordinates from -1 to 1.
struct Slice {
  int axis = 1;  // the axis that the plane is normal to: 0 x, 1 y, 2 z
  int size = 0;
  std::vector<float> target;      // phi at the support point nearest to each pixel
  std::vector<uint8_t> valid;     // of the same point: 0 in solid
  std::vector<uint8_t> seen;      // of the same point: in plain sight of the probe; a valid point that is not is occluded
  std::vector<float> stored;      // the representation at the pixel
  std::vector<float> difference;  // representation minus phi at that support point: no trace of the mosaic
};

// Of the three axis planes through the probe the one that tells most: function against bare tent, representation against
// function.
Slice makeSlice(const FunctionSet& set, uint64_t index, const Representation& representation, const float* theta, int size);

}  // namespace nlg
