// Runs all points of the plot on the same functions, interleaved, so that a slow moment of the machine hits all alike.
//
// The outer loops run over repeats and blocks of functions, the inner one over all points. A point's first run on every block gives
// its errors; where a block took no longer than repeat_seconds, the repeats give its times, each after an unmeasured run that brings
// the point's own weights and functions into the caches, as in a bake of many blocks. Points that take longer are run once: their
// times are those of the first run, each the mean of many long fits.
#pragma once

#include "validate/errors/function_error.h"
#include "validate/frontier/plot_point.h"

namespace nlg {

struct InterleaveOptions {
  int repeats = 5;               // timed runs of every short point on every block
  double repeat_seconds = 0.25;  // a point that takes longer on its first block is run once
};

// The times of one run on one block: µs of each of its functions, in its order.
struct BlockTimes {
  size_t block = 0;
  std::vector<double> elapsed_us;
};

struct PointMeasurement {
  std::vector<FunctionError> errors;  // by function, in the order of the blocks
  PooledMagnitudes leaks;             // over all of them
  std::vector<BlockTimes> times;
};

// returns    one a point, in their order
// progress   called with the number of finished runs
// throws     NumericalError when a theta's error is not finite
std::vector<PointMeasurement> measureInterleaved(const FunctionSet& set, const std::vector<FunctionBlock>& blocks,
                                                 const std::vector<PlotPoint>& points, const InterleaveOptions& options,
                                                 const std::function<void(int64_t done)>& progress);

}  // namespace nlg
