// Runs all points of the plot on the same functions, interleaved, so that slow moments of the machine affect all alike.
//
// The outer loops run over repeats and blocks of functions, the inner one over all runs. The first run on every block gives errors.
// Where it took no longer than repeat_seconds, the repeats give times. What takes next to no time is run once more before each
// repeat, unmeasured. That brings its own weights and functions into the caches, as in a bake of many blocks. Runs that take longer
// are made once; their times are those of the first run, each the mean of many long fits.
#pragma once

#include <ctime>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "datagen/dataset/function_set.h"
#include "validate/generators/measured_word.h"
#include "validate/generators/populations.h"

namespace nlg {

// The functions that every point of the plot runs on, and the blocks in which they run.
//
// One block: as many functions as a bake gives a generator at once, or a few less. The set must outlive it.
struct FunctionBlock {
  std::vector<uint64_t> functions;     // of the set
  std::vector<StoredFunction> stored;  // the same

  int count() const { return static_cast<int>(functions.size()); }
};

// Cuts the list into blocks of at most kBatchCount functions, as equal as they can be.
std::vector<FunctionBlock> makeBlocks(const FunctionSet& set, const std::vector<uint64_t>& functions);

inline constexpr Population kPopulations[] = {Population::theta, Population::hard};

const char* populationWords(Population population);  // "functions that take a θ"

struct ChosenFunctions {
  std::vector<uint64_t> with_theta;  // what points run on, as many of every scene
  std::vector<bool> hard;            // of these

  // Which of them the population holds.
  std::vector<bool> of(Population population) const;
};

// wanted   functions that take a theta; with fewer all are taken
// throws   InputError when no function takes a theta
ChosenFunctions chooseFunctions(const FunctionSet& set, uint64_t wanted, const PolicyOptions& policy, double hard_tent_rmse);

// Points of the plot of error against run time, and the runs that give them.

// Microseconds since it was made: of the thread that made it, or of the wall clock.
template <clockid_t clock>
class ClockStopwatch {
 public:
  double elapsedUs() const { return now() - start_us_; }

 private:
  static double now() {
    timespec time{};
    clock_gettime(clock, &time);
    return 1e6 * static_cast<double>(time.tv_sec) + 1e-3 * static_cast<double>(time.tv_nsec);
  }
  double start_us_ = now();
};

// Processor time of this thread: what other work on the machine takes away does not count. Reading it takes about .3 µs.
using Stopwatch = ClockStopwatch<CLOCK_THREAD_CPUTIME_ID>;
// Where several threads work.
using WallStopwatch = ClockStopwatch<CLOCK_MONOTONIC>;

// What a method made of one function.
struct FittedFunction {
  Representation representation;
  Theta theta;
  double elapsed_us = 0.0;  // processor time of the thread; of what runs in batches, its share of the batch
  bool took_fit = false;    // any step of Adam or Levenberg–Marquardt
};

// One method with all its settings.
struct PlotPoint {
  std::string representation;    // a name of kRepresentationNames
  std::string family;            // docs/reference/frontier.md
  std::optional<int> budget;     // what grows along the family: steps, coefficients, bits
  std::string label;             // "4 LM from theta0"
  std::vector<ThetaWord> words;  // what its theta is called; most points have none
  bool is_direct = false;        // a fit that sees no generator: a baseline at equal error
};

// By point of a run, then by function of a block.
using FittedFunctions = std::vector<std::vector<FittedFunction>>;

// A run gives one point, or several where one is on the way to another.
struct PlotRun {
  std::vector<PlotPoint> points;
  // theta of every function of a block, in its order, and the time that each took. The same theta every time.
  std::function<FittedFunctions(const FunctionBlock&)> run;
};

struct InterleaveOptions {
  int repeats = 5;               // timed runs of every short one on every block
  double repeat_seconds = 0.25;  // what takes longer on its fastest block is run once
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
