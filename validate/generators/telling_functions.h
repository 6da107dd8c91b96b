// Chooses functions for pictures, and the slices that show them.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "datagen/dataset/function_set.h"
#include "validate/generators/policy_words.h"

namespace nlg {

// Slices through weighting functions, for pictures.
//
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

struct TellingFunction {
  std::string which;  // "p5", "median", "p95", "worst"
  uint64_t function = 0;
};

// By the blend RMSE of what is stored, among the hard functions. Where none is hard, among those that take a theta; where none does, among
// all. At a percentile stands the function with the most valid points among those whose ranks lie within a two-hundredth of all
// around it: a picture of solid says nothing.
std::vector<TellingFunction> tellingFunctions(const MeasuredWord& stored, const FunctionSet& set, const Populations& populations);

// Slices through them, for slices.json: docs/reference/formats.md.
void appendSlices(const Representation& representation, const PolicyWords& words, const FunctionSet& set,
                  const Populations& populations, nlohmann::ordered_json* slices);

}  // namespace nlg
