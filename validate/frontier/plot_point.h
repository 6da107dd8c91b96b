// Points of the plot of error against run time, and the runs that give them.
#pragma once

#include <ctime>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "validate/frontier/chosen_functions.h"

namespace nlg {

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
  std::string representation;    // a name of kRepresentationNames; of a choice, those that it chose from, joined by "+"
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

}  // namespace nlg
