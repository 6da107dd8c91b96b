// Runs all points of the plot on the same functions, interleaved, so that slow moments of the machine affect all alike.
//
// The outer loops run over repeats and blocks of functions, the inner one over all runs. The first run on every block gives errors.
// Where it took no longer than repeat_seconds, the repeats give times. What takes next to no time is run once more before each
// repeat, unmeasured. That brings its own weights and functions into the caches, as in a bake of many blocks. Runs that take longer
// are made once; their times are those of the first run, each the mean of many long fits.
#pragma once

#include "validate/frontier/chosen_functions.h"
#include "validate/frontier/plot_point.h"
#include "validate/generators/measured_word.h"

namespace nlg {

struct InterleaveOptions {
  int repeats = 5;               // timed runs of every short one on every block
  double repeat_seconds = 0.25;  // what takes longer on its first block is run once
};

// The times of one run on one block: µs of each of its functions, in its order.
struct BlockTimes {
  size_t block = 0;
  std::vector<double> elapsed_us;
};

struct PointMeasurement {
  std::vector<double> blend_rmse, rmse;  // by function, in the order of the blocks
  std::vector<bool> fails_check;         // by function
  std::vector<bool> took_fit;            // by function
  PooledMagnitudes leaks, leaks_hard;    // over all of them, over the hard ones
  std::vector<BlockTimes> times;
};

// functions   whose with_theta the blocks hold, in their order
// check       the policy's, by whose loss and thresholds errors are judged
// returns     one a point, run after run
// progress    called with the number of finished runs
// throws      NumericalError when a theta's error is not finite
std::vector<PointMeasurement> measureInterleaved(const FunctionSet& set, const ChosenFunctions& functions,
                                                 const std::vector<FunctionBlock>& blocks, const std::vector<PlotRun>& runs,
                                                 const CheckOptions& check, const InterleaveOptions& options,
                                                 const std::function<void(int64_t done)>& progress);

}  // namespace nlg
