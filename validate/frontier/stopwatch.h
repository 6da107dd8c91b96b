// Microseconds since it was made: of the thread that made it, or of the wall clock.
#pragma once

#include <ctime>

namespace nlg {

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

}  // namespace nlg
